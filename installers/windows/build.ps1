# Builds dist\adibas-VERSION-setup.exe and tries out the frozen program and the installer.
# Needs Python 3.11 to 3.13 and Inno Setup 6 (iscc on the path). Not run by us yet.
$ErrorActionPreference = "Stop"
$PSNativeCommandUseErrorActionPreference = $true
Set-Location (Join-Path $PSScriptRoot "..\..")

python -m venv .venv
.venv\Scripts\python -m pip install --quiet --no-deps --require-hashes -r installers\requirements.lock
.venv\Scripts\python -m pip install --quiet --no-deps --no-build-isolation -e .
.venv\Scripts\python -m installers.manual.build
.venv\Scripts\python -m installers.freezing

$version = (dist\adibas\adibas.exe --version).Split(" ")[1]
iscc /Qp "/DAppVersion=$version" installers\windows\adibas.iss

$setup = "dist\adibas-$version-setup.exe"
$place = Join-Path $env:TEMP "adibas-check"
Start-Process -Wait $setup "/VERYSILENT /CURRENTUSER /DIR=$place"
& "$place\adibas.exe" --version
& "$place\adibas.exe" demo --out (Join-Path $env:TEMP "adibas-demo")
Start-Process -Wait "$place\unins000.exe" "/VERYSILENT"
Start-Sleep 5  # the uninstaller goes on from a copy of itself
if (Test-Path $place) { throw "something is left in $place" }
Write-Output $setup

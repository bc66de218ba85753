#!/bin/bash
# Builds dist/adibas-VERSION.dmg and tries out the program in it. Needs macOS on a processor of Apple
# (numba is not made for Intel's any more) and Python 3.11 to 3.13.
# CODESIGN_IDENTITY (a Developer ID) signs it; without one it is signed for this Mac only, and others
# open it with the context menu. Not run by us yet.
set -euo pipefail
cd "$(dirname "$0")/../.."

python3 -m venv .venv
.venv/bin/python -m pip install -q --no-deps --require-hashes -r installers/requirements.lock
.venv/bin/python -m pip install -q --no-deps --no-build-isolation -e .
.venv/bin/python -m installers.manual.build
.venv/bin/python -m installers.freezing

app=dist/ADiBAS.app
# The kernels were added after PyInstaller had signed.
codesign --force --deep --sign "${CODESIGN_IDENTITY:--}" "$app"
version=$("$app/Contents/MacOS/adibas" --version | cut -d ' ' -f 2)
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cp -R "$app" "$folder/"
ln -s /Applications "$folder/Applications"
hdiutil create -quiet -volname ADiBAS -srcfolder "$folder" -ov -format UDZO "dist/adibas-$version.dmg"

mount=$folder/mounted
hdiutil attach -quiet -nobrowse -mountpoint "$mount" "dist/adibas-$version.dmg"
"$mount/ADiBAS.app/Contents/MacOS/adibas" --version
"$mount/ADiBAS.app/Contents/MacOS/adibas" demo --out "$folder/demo"
hdiutil detach -quiet "$mount"
echo "dist/adibas-$version.dmg"

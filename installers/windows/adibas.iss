; Inno Setup 6: makes dist\adibas-VERSION-setup.exe of dist\adibas.
; iscc /DAppVersion=0.1.0 installers\windows\adibas.iss      (installers\windows\build.ps1 does it)

#ifndef AppVersion
  #error Say /DAppVersion=...
#endif

[Setup]
AppId={{6B1B7C52-6C0E-4D0B-9D0B-5F0C1E3A7A11}
AppName=ADiBAS
AppVersion={#AppVersion}
AppPublisher=The ADiBAS authors
DefaultDirName={autopf}\ADiBAS
DefaultGroupName=ADiBAS
DisableProgramGroupPage=yes
LicenseFile=..\..\LICENSE
OutputDir=..\..\dist
OutputBaseFilename=adibas-{#AppVersion}-setup
SetupIconFile=..\..\build\icons\adibas.ico
UninstallDisplayIcon={app}\adibas.exe
ArchitecturesAllowed=x64compatible
ArchitecturesInstallIn64BitMode=x64compatible
; A clinic's computer often lets nobody write into Program Files: then it goes to the user's own folder.
PrivilegesRequired=lowest
PrivilegesRequiredOverridesAllowed=dialog
Compression=lzma2
SolidCompression=yes
ChangesAssociations=yes
WizardStyle=modern

[Languages]
Name: "en"; MessagesFile: "compiler:Default.isl"
Name: "es"; MessagesFile: "compiler:Languages\Spanish.isl"
Name: "ca"; MessagesFile: "compiler:Languages\Catalan.isl"
Name: "pt"; MessagesFile: "compiler:Languages\BrazilianPortuguese.isl"

[Tasks]
Name: "desktopicon"; Description: "{cm:CreateDesktopIcon}"; GroupDescription: "{cm:AdditionalIcons}"; Flags: unchecked

[Files]
Source: "..\..\dist\adibas\*"; DestDir: "{app}"; Flags: ignoreversion recursesubdirs createallsubdirs

[InstallDelete]
; Files of the version before; patients' data are never here, they are in %LOCALAPPDATA%\adibas.
Type: filesandordirs; Name: "{app}\_internal"

[Icons]
Name: "{autoprograms}\ADiBAS"; Filename: "{app}\adibas-window.exe"
Name: "{autodesktop}\ADiBAS"; Filename: "{app}\adibas-window.exe"; Tasks: desktopicon

[Registry]
Root: HKA; Subkey: "Software\Classes\.mcap\OpenWithProgids"; ValueType: string; ValueName: "ADiBAS.recording"; ValueData: ""; Flags: uninsdeletevalue
Root: HKA; Subkey: "Software\Classes\.oni\OpenWithProgids"; ValueType: string; ValueName: "ADiBAS.recording"; ValueData: ""; Flags: uninsdeletevalue
Root: HKA; Subkey: "Software\Classes\ADiBAS.recording"; ValueType: string; ValueName: ""; ValueData: "ADiBAS recording"; Flags: uninsdeletekey
Root: HKA; Subkey: "Software\Classes\ADiBAS.recording\DefaultIcon"; ValueType: string; ValueName: ""; ValueData: "{app}\adibas.exe,0"
Root: HKA; Subkey: "Software\Classes\ADiBAS.recording\shell\open\command"; ValueType: string; ValueName: ""; ValueData: """{app}\adibas-window.exe"" ""%1"""

[Run]
Filename: "{app}\adibas-window.exe"; Description: "{cm:LaunchProgram,ADiBAS}"; Flags: nowait postinstall skipifsilent

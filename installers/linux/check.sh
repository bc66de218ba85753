#!/bin/bash
# Installs the package into a fresh Debian (debootstrap), tries it out as an ordinary user, removes it,
# and tells what is left. Needs root, debootstrap, Xvfb, xwininfo (x11-utils) and a network.
#
#     installers/linux/check.sh [PACKAGE.deb]
#
# DEBIAN_RELEASE (bookworm) and DEBIAN_MIRROR (debootstrap's own) say of what and from where.
# SOURCE_PROGRAM (.venv/bin/adibas) is what the time until the window is compared with.
set -euo pipefail
cd "$(dirname "$0")/../.."

release=${DEBIAN_RELEASE:-bookworm}
package=$(realpath "${1:-$(ls -t dist/adibas_*.deb | head -n 1)}")
source_program=$(realpath -s "${SOURCE_PROGRAM:-.venv/bin/adibas}")
most_megabytes=450
most_times_slower=2
base=$PWD/build/chroot-$release.tar
root=$PWD/build/chroot
report=$PWD/build/check
failures=0

end() {
    [ -z "${xvfb:-}" ] || kill "$xvfb" 2>/dev/null || true
    for place in tmp/.X11-unix dev/shm proc; do
        umount "$root/$place" 2>/dev/null || true
    done
    rm -rf --one-file-system "$root"
}
inside() { chroot "$root" /usr/bin/env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin LC_ALL=C.UTF-8 \
    DEBIAN_FRONTEND=noninteractive http_proxy="${http_proxy:-}" "$@"; }
as_user() { inside runuser -u clinician -- env -C /home/clinician HOME=/home/clinician "$@"; }
files() { inside find / -xdev \( -path /proc -o -path /tmp -o -path /home -o -path /var/cache/apt \
    -o -path /var/cache/debconf -o -path /var/lib/apt -o -path /var/lib/dpkg -o -path /var/log -o -path /run \) -prune \
    -o -print | sort; }
told() {  # a line of the report: what, and whether it is as it should be
    if [ "$2" = ok ]; then echo "ok      $1"; else
        echo "FAILED  $1"
        failures=$((failures + 1))
    fi
}
runs_clean() {  # what is tried, then a command: exit code 0 and nothing on stderr
    local what=$1 code=0
    shift
    "$@" >"$report/stdout" 2>"$report/stderr" || code=$?
    if [ "$code" = 0 ] && ! [ -s "$report/stderr" ]; then told "$what" ok; else
        told "$what (exit code $code)" no
        head -n 20 "$report/stderr"
    fi
}
runs() {  # arguments of adibas: exit code 0; what it says of the measurement is not judged
    local code=0
    as_user env ADIBAS_PASSPHRASE=adibas-demo adibas "$@" >"$report/stdout" 2>"$report/stderr" ||
        code=$?
    if [ "$code" = 0 ] && ! grep -q Traceback "$report/stderr"; then told "adibas $1 $2" ok; else
        told "adibas $* (exit code $code)" no
        tail -n 20 "$report/stderr"
    fi
}
runs_every_part() {  # each brings libraries of its own, which a frozen program may lack
    runs record simulator:bend --seconds 2 --out r.mcap
    runs record simulator:board --seconds 1 --out board.mcap
    runs record simulator:anterior_led --seconds 1 --out led.mcap
    runs convert r.mcap r.oni
    runs pose r.mcap --out j.csv
    runs movement j.csv --out m.c3d --out m.trc --out m.xlsx --out m.pdf
    runs behaviour j.csv --out b.xlsx
    runs posture demo/recording.mcap --markers demo/colours.json --out p.pdf --out p.json
    runs markers learn demo/recording.mcap --seed 520,514 --out c.json
    runs limbs segment r.mcap --frames 0:2 --out limbs
    runs limbs propose r.mcap --frames 0:2 --out labels
    runs map demo/recording.mcap --frames 0:10 --out map.ply --trajectory path.txt
    runs protocols list
    local examples=home/clinician/examples method
    .venv/bin/python docs/manual/developers/gesture_example.py "$root/$examples"
    for method in likeness hmm gmm-dtw; do  # hmm: of libraries that nothing else asks for
        runs gestures train "/$examples" --method "$method" --out "$method.json"
        runs gestures detect "/$examples/p0.joints.csv" --model "$method.json" --out e.csv
    done
    runs calibrate --print-board A4 --out board.pdf
    runs body posterior=demo/recording.mcap --out back.ply
    runs sessions list --store demo/store
    local session
    session=$(grep -oE '[0-9a-f]{32}' "$report/stdout" | head -n 1)
    runs export fhir "$session" --store demo/store --out f.json
    runs export dicom "$session" --store demo/store --out d
    runs sessions backup --store demo/store --out s.adibas-backup
    runs sessions restore s.adibas-backup --into restored
    runs sessions recovery-key --store demo/store --out key.pdf
    local home=$root/home/clinician
    cp "$report/stdout" "$home/key"
    echo adibas-demo-2 >"$home/new"
    runs sessions recover --store demo/store --recovery-key-file key --new-passphrase-file new
    runs sessions verify --store demo/store --passphrase-file new
}
make_base() {
    [ -f "$base" ] && return
    # shellcheck disable=SC2086  # no mirror: debootstrap's own
    debootstrap --variant=minbase "$release" "$root" ${DEBIAN_MIRROR:-} >"$report/debootstrap"
    cp /etc/resolv.conf "$root/etc/"
    mount -t proc proc "$root/proc"
    inside apt-get -q update >"$report/apt"
    inside apt-get -q install -y --no-install-recommends apt-utils >>"$report/apt" 2>&1
    inside apt-get clean
    inside useradd --create-home clinician
    umount "$root/proc"
    tar -C "$root" -cf "$base" .
    rm -rf --one-file-system "$root"
}

mkdir -p "$report"
rm -rf --one-file-system "$root"
trap end EXIT
make_base
mkdir -p "$root"
tar -C "$root" -xf "$base"
mount -t proc proc "$root/proc"
mkdir -p "$root/dev/shm"
mount -t tmpfs tmpfs "$root/dev/shm"
cp /etc/resolv.conf "$root/etc/"
files >"$report/files-before"

echo "In Debian $(cat "$root/etc/debian_version"), $(inside ldd --version | head -n 1):"
cp "$package" "$root/tmp/adibas.deb"
inside apt-get -q update >"$report/apt" 2>&1
runs_clean "apt-get install" inside apt-get -qq install -y --no-install-recommends \
    -o Dpkg::Use-Pty=0 /tmp/adibas.deb
megabytes=$(inside du -sm --apparent-size /usr/lib/adibas | cut -f 1)
if [ "$megabytes" -le "$most_megabytes" ]; then size=ok; else size=no; fi
told "installed size $megabytes MB, at most $most_megabytes" $size

page=usr/lib/adibas/_internal/resources/manual/manual/es/first-session.html
if [ -s "$root/$page" ]; then manual=ok; else manual=no; fi
told "the manual is there" $manual

plugins=usr/lib/adibas/_internal/PySide6/Qt/plugins/printsupport
if [ -s "$root/$plugins/libcupsprintersupport.so" ]; then printing=ok; else printing=no; fi
told "printers can be found" $printing

runs_clean "adibas --version" as_user adibas --version
cat "$report/stdout"
runs_clean "adibas doctor" as_user adibas doctor
start=$(date +%s%N)
runs_clean "adibas demo" as_user adibas demo --out demo
echo "        $((($(date +%s%N) - start) / 1000000)) ms"
runs_clean "adibas without a display" as_user adibas
runs_clean "the window offscreen, ended by SIGTERM" as_user env DISPLAY=:none \
    QT_QPA_PLATFORM=offscreen timeout --preserve-status -s TERM 20 adibas
runs_every_part

display=$((90 + RANDOM % 9000))
Xvfb ":$display" -screen 0 1400x1000x24 -nolisten tcp >"$report/xvfb" 2>&1 &
xvfb=$!
for _ in {1..300}; do  # a busy computer takes its time
    [ -S "/tmp/.X11-unix/X$display" ] && break
    sleep 0.1
done
mkdir -p "$root/tmp/.X11-unix"
mount --bind /tmp/.X11-unix "$root/tmp/.X11-unix"
.venv/bin/python -m installers.first_window --display ":$display" --picture "$report/window.png" \
    --root "$root" --user clinician --source "$source_program" --at-most "$most_times_slower" \
    2>"$report/stderr" && seen=ok || seen=no
told "first window under Xvfb" $seen
[ -s "$report/stderr" ] && cat "$report/stderr"
bugs=$(inside grep -rE "ERROR|CRITICAL" /home/clinician/.local/state/adibas || true)
if [ -z "$bugs" ]; then log=ok; else log=no; fi
told "no error in the log $bugs" $log
runs_clean "adibas demo after the window" as_user adibas demo --out again
compiled=$(inside find /home/clinician -name '*.nbc' -printf '%f\n')
if [ -z "$compiled" ]; then ready=ok; else ready=no; fi
told "kernels ready, none compiled on the spot $compiled" $ready

runs_clean "apt-get purge" inside apt-get -qq purge -y --auto-remove \
    -o Dpkg::Use-Pty=0 adibas
files >"$report/files-after"
comm -13 "$report/files-before" "$report/files-after" >"$report/left"
if [ -s "$report/left" ]; then left=no; else left=ok; fi
told "nothing of the program is left" $left
cat "$report/left"
echo "In the user's home:"
inside find /home/clinician -mindepth 2 -maxdepth 3 -path "*/.*" | sort
echo "$failures failed"
exit "$((failures > 0))"

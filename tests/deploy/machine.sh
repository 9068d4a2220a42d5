#!/bin/bash
# SPDX-License-Identifier: MIT
# A machine for one test: systemd as process 1 over this system's files, with a file system (an
# overlay in memory), processes, network and control group of its own, so that nothing of it stays
# or is seen outside. It ends with this script. Needs root.
# Usage: machine.sh FOLDER     says "up" on stdout when the machine runs; FOLDER/init is its process 1
set -eu

# In the new namespaces: lays out the files and becomes process 1.
if [ "${1:-}" = --inside ]; then
    root=$2/root
    mount --make-rprivate /
    mount -t tmpfs -o mode=755 tmpfs "$2"
    mkdir "$2/upper" "$2/work" "$root"
    mount -t overlay -o "lowerdir=/,upperdir=$2/upper,workdir=$2/work" overlay "$root"
    mount -t proc proc "$root/proc"
    mount --bind "$root/proc/sys" "$root/proc/sys"
    mount -o remount,ro,bind "$root/proc/sys" # the kernel is not the machine's own
    mount -t sysfs -o ro sysfs "$root/sys"
    mount -t cgroup2 cgroup2 "$root/sys/fs/cgroup"
    for folder in dev run tmp; do
        mount -t tmpfs -o mode=1777 tmpfs "$root/$folder"
    done
    for device in null zero full random urandom tty; do
        touch "$root/dev/$device"
        mount --bind "/dev/$device" "$root/dev/$device"
    done
    mkdir "$root/dev/shm" "$root/dev/pts" "$root/dev/mqueue"
    mount -t tmpfs tmpfs "$root/dev/shm"
    mount -t devpts -o newinstance,ptmxmode=0666 devpts "$root/dev/pts"
    ln -s pts/ptmx "$root/dev/ptmx"
    # What this system starts is not started there: a journal, and what the test asks for.
    rm -rf "$root"/etc/systemd/system "$root"/etc/systemd/system.conf* \
        "$root"/usr/sbin/policy-rc.d \
        "$root"/lib/systemd/system/{sysinit,local-fs,timers,multi-user}.target.wants
    mkdir "$root/etc/systemd/system"
    printf '[Unit]\nRequires=sysinit.target sockets.target\nAfter=sysinit.target\n' \
        >"$root/etc/systemd/system/machine.target"
    ip link set lo up
    cd "$root"
    mkdir -p old
    pivot_root . old
    umount -l old
    exec env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin container=test \
        /lib/systemd/systemd --unit=machine.target --show-status=0
fi

folder=$(realpath "$1")
group=$(awk '$3 == "cgroup2" {print $2; exit}' /proc/mounts)
[ -n "$group" ] || { echo "$0: no control groups of version 2 are mounted here" >&2; exit 1; }
group=$group/draped-test-$$
mkdir -p "$folder/files" "$group"
init=
stop() {
    trap - EXIT
    [ -z "$init" ] || { kill -KILL "$init"; wait; } 2>/dev/null || true
    for _ in $(seq 50); do # the kernel lets go of a group a moment after its last process
        find "$group" -depth -type d -exec rmdir {} + 2>/dev/null && break
        sleep 0.1
    done
}
trap stop EXIT
trap 'exit 143' TERM INT
(echo "$BASHPID" >"$group/cgroup.procs" &&
    exec unshare --mount --pid --fork --net --uts --ipc --cgroup \
        "$BASH" "$0" --inside "$folder/files" >"$folder/console" 2>&1) &
for _ in $(seq 200); do
    [ -n "$init" ] || init=$(pgrep -P $! 2>/dev/null || true)
    if [ -n "$init" ] && state=$(nsenter -t "$init" -a systemctl is-system-running 2>/dev/null) ||
        [ "${state:-}" = degraded ]; then
        echo "$init" >"$folder/init"
        echo up
        wait
        exit
    fi
    kill -0 $! 2>/dev/null || break
    sleep 0.1
done
cat "$folder/console" >&2
echo "$0: the machine did not start" >&2
exit 1

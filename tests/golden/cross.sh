#!/bin/bash
# Golden scenarios on another CPU, emulated by qemu: every hash and every metric of tests/golden/hashes.csv to the last digit.
#   tests/golden/cross.sh aarch64|riscv64 [sample | all | ID...] [--jobs N] [--csv FILE]
# Debian packages: qemu-user, gcc-aarch64-linux-gnu, gcc-riscv64-linux-gnu; cJSON is built from Debian's source package, which apt fetches once.
# Exit 77, with the reason: it was not run.
set -euo pipefail
cd "$(dirname "$0")/../.."
table=tests/golden/hashes.csv
cpu=${1:?which CPU: aarch64 or riscv64}
shift
jobs=1 csv='' ids=()
while [ $# -gt 0 ]; do
    case $1 in
        --jobs) jobs=$2; shift ;;
        --csv) csv=$2; shift ;;
        sample) mapfile -t -O ${#ids[@]} ids < <(grep -v '^#' tests/golden/cross/sample.txt) ;;
        all) mapfile -t -O ${#ids[@]} ids < <(tail -n +2 $table | cut -d, -f1) ;;
        *) ids+=("$1") ;;
    esac
    shift
done
not_run() { echo "not run: $*"; exit 77; }

for tool in "qemu-$cpu" "$cpu-linux-gnu-gcc" cmake ninja; do
    command -v "$tool" >/dev/null || not_run "$tool is not installed (apt-get install qemu-user gcc-$cpu-linux-gnu)"
done

# ---- cJSON, with Debian's patches ----
build=$PWD/build/cross
mkdir -p "$build"
sources() {
    local list=$build/apt options
    mkdir -p "$list/lists/partial"
    # from where this machine has its packages
    apt-get indextargets --format 'deb-src $(REPO_URI) $(RELEASE) main' 'Created-By: Packages' 'Component: main' | sort -u >"$list/sources.list"
    options=(-q -o "Dir::Etc::sourcelist=$list/sources.list" -o Dir::Etc::sourceparts=- -o "Dir::State::Lists=$list/lists"
        -o Dir::Cache::pkgcache= -o Dir::Cache::srcpkgcache= -o APT::Sandbox::User=)
    apt-get "${options[@]}" update && cd "$build" && apt-get "${options[@]}" source --download-only cjson || return 1
    rm -rf cjson.new && mkdir cjson.new
    tar -xf cjson_*.orig.tar.gz -C cjson.new --strip-components=1
    tar -xf cjson_*.debian.tar.xz -C cjson.new
    (cd cjson.new && while read -r patch; do patch -s -p1 <"debian/patches/$patch"; done < <(grep -v '^#' debian/patches/series 2>/dev/null))
    mkdir include && mv cjson.new include/cjson
}
(
    flock 9
    [ -e "$build/include/cjson/cJSON.c" ] || (sources) >"$build/cjson.log" 2>&1
) 9>"$build/.lock" || not_run "the sources of cJSON could not be fetched: $(tail -n 1 "$build/cjson.log")"

# ---- the engine ----
[ -e "$build/$cpu/build.ninja" ] || cmake -S tests/golden/cross -B "$build/$cpu" -G Ninja -DCMAKE_BUILD_TYPE=Release -DCMAKE_SYSTEM_NAME=Linux "-DCMAKE_SYSTEM_PROCESSOR=$cpu" \
    "-DCMAKE_C_COMPILER=$cpu-linux-gnu-gcc" -DCMAKE_C_COMPILER_LAUNCHER="${CMAKE_C_COMPILER_LAUNCHER:-}" "-DCJSON=$build/include/cjson" >/dev/null
ninja -C "$build/$cpu" >"$build/$cpu.log" 2>&1 || { tail -n 30 "$build/$cpu.log"; exit 1; }

# ---- the hashes ----
started=$(date -u +%Y-%m-%dT%H:%MZ)
printf '%s\n' "${ids[@]}" | xargs -P "$jobs" -n 1 "qemu-$cpu" "$build/$cpu/hashes" >"$build/$cpu.csv" || true
want=$(mktemp)
trap 'rm -f "$want"' EXIT
for id in "${ids[@]}"; do awk -F, -v id="$id" '$1 == id' $table; done | sort >"$want"
equal=$(sort "$build/$cpu.csv" | comm -12 - "$want" | wc -l)
echo "$cpu: $equal of ${#ids[@]} scenarios with the hashes and metrics of $table"
if [ -n "$csv" ]; then
    [ -e "$csv" ] || echo "cpu,scenarios,equal,compiler,emulator,commit,date" >"$csv"
    echo "$cpu,${#ids[@]},$equal,$("$cpu-linux-gnu-gcc" -dumpfullversion),$("qemu-$cpu" --version | sed -n '1s/.*version \([^ ]*\).*/\1/p'),$(git rev-parse --short=12 HEAD),$started" >>"$csv"
fi
[ "$equal" = "${#ids[@]}" ] && exit 0
sort "$build/$cpu.csv" | diff "$want" - | head -n 20
exit 1

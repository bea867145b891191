# shellcheck shell=bash
# What ./dev test, check, cross, fuzz and container-test do. `dev` reads this and has what installs and builds.

# A stage is a function that prints to its log. What it counts is read from there; a stage that fails without
# a count, or finds no test, counts as one failure.

passed=0 failed=0 skipped=0 table="" stage_pid='' others_pid=''

stage() { # NAME COUNTER COMMAND...
    local name=$1 counter=$2 log status=0 start=$SECONDS p=0 f=0 s=0
    shift 2
    log=build/test-logs/${name// /-}.log
    say "$name"
    : >"$log" # before it is shown
    # Not a pipe: a process left behind by a test would keep it open for ever.
    "$@" >"$log" 2>&1 </dev/null &
    stage_pid=$!
    tail -n +1 -s 0.2 -f --pid=$stage_pid "$log"
    wait $stage_pid || status=$?
    read -r p f s < <("$counter" "$log" "$status")
    if [ "$f" = 0 ] && { [ "$status" != 0 ] || [ "$p" = 0 ]; }; then f=1; fi
    passed=$((passed + p)) failed=$((failed + f)) skipped=$((skipped + s))
    table+=$(printf '%-28s %7d %7d %7d %6ds' "$name" "$p" "$f" "$s" $((SECONDS - start)))$'\n'
}

# Counters print: passed failed skipped
count_one() { if [ "$2" = 0 ]; then echo 1 0 0; else echo 0 1 0; fi; }
count_ctest() {
    awk '/\*\*\*Skipped/ { skipped++ }
         /^[0-9]+% tests passed, [0-9]+ tests? failed out of [0-9]+$/ { failed = $4; total = $NF }
         END { print total ? total - failed - skipped : 0, failed + 0, skipped + 0 }' "$1"
}
count_node() {
    awk '/^. (pass|fail|cancelled|skipped|todo) [0-9]+$/ || /^[^ ]+ (pass|fail|cancelled|skipped|todo) [0-9]+$/ { n[$2] = $3 }
         END { print n["pass"] + 0, n["fail"] + n["cancelled"] + 0, n["skipped"] + n["todo"] + 0 }' "$1"
}

# Of two runs: what failed in the first and not in the second has passed late.
count_late() {
    awk '/^[^ ]+ (pass|fail|cancelled|skipped|todo) [0-9]+$/ { if ($2 in n && $2 == "pass") again = 1; if (again) m[$2] = $3; else n[$2] = $3 }
         END { f = n["fail"] + n["cancelled"]; l = again ? m["fail"] + m["cancelled"] : f
               print n["pass"] + f - l, l, n["skipped"] + n["todo"] + 0 }' "$1"
}

# Since Linux 6.6 the address space is shuffled more than this thread sanitizer can take.
still_addresses() {
    if setarch -R true 2>/dev/null; then setarch -R "$@"; else "$@"; fi
}

ctest_stage() { # PRESET [LABEL ROOM]: everything, or the tests with a label, which the target tests_ROOM builds
    local folder=build/$1 select=() target=()
    [ "$1" != release ] || folder=build
    if [ $# -gt 1 ]; then select=(-L "^$2\$") target=(-- --target "tests_$3"); fi
    compile "$1" -DLAGLAB_TESTS=ON -DLAGLAB_WERROR=ON ${target[@]+"${target[@]}"} || return 1
    still_addresses ctest --test-dir "$folder" -j "$(nproc)" --output-on-failure --no-tests=error \
        ${select[@]+"${select[@]}"}
}

node_stage() { # FOLDER FILES-AT-A-TIME [SECONDS]
    local files=("$1"/*.test.mjs)
    [ -e "${files[0]}" ] || { echo "no test in $1"; return 1; }
    LAGLAB_BIN=$PWD/build/laglab timeout --foreground -k 10 "${3:-1500}" \
        node --test --test-concurrency="$2" --test-reporter=spec "${files[@]}"
}

# Tests in a browser are now and then late: two browsers at a time share two cores, and those without a graphics card draw by the
# processor. Those that failed are run once more, by name and one at a time, and what passed only then is reported in the log
# and before the closing line. What fails twice has failed.
browser_stage() { # FOLDER FILES-AT-A-TIME SECONDS
    local log=build/test-logs/${1##*/}-first.log status line file='' files=() names=()
    node_stage "$@" 2>&1 | tee "$log"
    status=${PIPESTATUS[0]}
    [ "$status" != 0 ] || return 0
    # The list at the end: a line with the place of a test, then one with its name and time.
    while IFS= read -r line; do
        if [[ $line =~ ^'test at '(.*/)?("$1"/[a-z]+\.(test\.)?mjs): ]]; then
            file=${BASH_REMATCH[2]}
        elif [ -n "$file" ] && [[ $line =~ ^[^\ ]+\ (.*)\ \([0-9.]+ms\)$ ]]; then
            files+=("$file")
            names+=(--test-name-pattern "^$(sed 's#[][\\^$.*+?(){}|/]#\\&#g' <<<"${BASH_REMATCH[1]}")\$")
            file=''
        fi
    done <"$log"
    [ ${#files[@]} -gt 0 ] || return "$status"
    # A test that several files share is named by the place where it is written: then each file of the folder is asked for it.
    if printf '%s\n' "${files[@]}" | grep -qv '\.test\.mjs$'; then files=("$1"/*.test.mjs); fi
    mapfile -t files < <(printf '%s\n' "${files[@]}" | sort -u)
    say "once more: ${files[*]}"
    LAGLAB_BIN=$PWD/build/laglab timeout --foreground -k 10 600 \
        node --test --test-concurrency=1 --test-reporter=spec "${names[@]}" "${files[@]}"
}

# The builds that only tests need, compiled while the tests of daemon and page mostly wait. What fails here fails again,
# and is shown, in its own stage.
compile_others() {
    renice -n 19 -p "$BASHPID" >/dev/null
    compile asan -DLAGLAB_TESTS=ON -DLAGLAB_WERROR=ON
    compile debug -DLAGLAB_TESTS=ON -DLAGLAB_WERROR=ON -- --target tests_golden
    compile clang -DLAGLAB_TESTS=ON -DLAGLAB_WERROR=ON -- --target tests_golden
    compile tsan -DLAGLAB_TESTS=ON -DLAGLAB_WERROR=ON -- --target tests_of_threads
}

# The tests use the JavaScript client, which names types that the build makes.
types_stage() {
    [ "$1" != tests/tsconfig.json ] || [ -e build/clients/js/types/api.d.ts ] || build --target client_types || return 1
    node_modules/.bin/tsc --noEmit -p "$1"
}
# tests/structure/spelling.txt: names and abbreviations that codespell takes for slips
spelling_stage() {
    find . \( -name node_modules -o -name build -o -name .git -o -name corpus -o -name results \) -prune -o -type f \
        \( -name '*.md' -o -name '*.[ch]' -o -name '*.inc' -o -name '*.js' -o -name '*.mjs' -o -name '*.py' -o -name '*.yaml' \
        -o -name '*.json' -o -name dev \) -not -name 'package-lock.json' -not -path './www/words/de.json' -not -path './www/words/scenarios/*' -not -path './www/words/messages/*' -print0 |
        xargs -0 codespell --quiet-level 3 --ignore-words tests/structure/spelling.txt --ignore-regex '"de": "[^"]*"' # German
}
lint_stage() { node_modules/.bin/biome check --error-on-warnings; } # rules and layout
# Sources of src that differ from the main branch, and those that include a header that does.
changed_sources() {
    local base file
    base=$(git merge-base HEAD main 2>/dev/null || git rev-parse HEAD)
    { git diff --name-only --diff-filter=d "$base" -- src; git ls-files --others --exclude-standard -- src; } |
        while read -r file; do
            case $file in
                *.c) echo "$file" ;;
                *.h | *.inc) grep -rlF --include='*.c' "\"${file#src/}\"" src || true ;;
            esac
        done | sort -u
}
# clang 14 does not know gcc's options of link-time optimisation and inlining.
tidy_stage() { # [--all]
    local files
    [ -e build/compile_commands.json ] || cmake --preset release -DLAGLAB_TESTS=OFF >/dev/null || return 1
    mkdir -p build/tidy
    sed -E 's/ (-f(lto=2|fat-lto-objects)|--param=[^ ]*)//g' build/compile_commands.json >build/tidy/compile_commands.json
    if [ "${1:-}" = --all ]; then files=$(find src -name '*.c'); else files=$(changed_sources); fi
    [ -n "$files" ] || { echo "no source of src has changed"; return; }
    printf '%s\n' "$files" | xargs -P "$(nproc)" -n 12 clang-tidy-14 -p build/tidy --quiet 2>/dev/null
}
format_stage() { c_files | xargs -r clang-format-14 --dry-run -Werror; }

run_test() { # [--fast]
    local fast='' late='' folder=''
    case "${1:-}" in
        '') ;;
        --fast) fast=1 ;;
        -h | --help) help; return ;;
        *) echo "dev: test takes --fast or nothing; got $1" >&2; return 2 ;;
    esac
    install_all_tests
    mkdir -p build/test-logs
    trap 'kill "$stage_pid" "$others_pid" 2>/dev/null; exit 130' INT TERM
    set +e
    stage "ctest release" count_ctest ctest_stage release
    if [ -z "$fast" ]; then
        stage "release by a profile" count_one release --target laglab
        compile_others >build/test-logs/other-builds.log 2>&1 </dev/null &
        others_pid=$!
    fi
    stage "types of the page" count_one types_stage tsconfig.json
    stage "types of the report" count_one types_stage www/report/tsconfig.json
    stage "types of the tests" count_one types_stage tests/tsconfig.json
    stage "layout of C" count_one format_stage
    stage "spelling" count_one spelling_stage
    stage "lint of JavaScript" count_one lint_stage
    stage "clang-tidy" count_one tidy_stage --all
    stage "node tests api" count_node node_stage tests/api 2
    if [ -z "$fast" ]; then
        stage "node tests daemon" count_node node_stage tests/daemon 1
        stage "node tests page" count_late browser_stage tests/page 2 2900
        stage "node tests browsers" count_late browser_stage tests/browsers 1 1500
        stage "instructions" count_node node_stage tests/cost 2
        for folder in page browsers; do
            if grep -q '^== once more' "build/test-logs/node-tests-$folder.log"; then
                late+=" $folder $(count_node "build/test-logs/$folder-first.log" | cut -d' ' -f2)"
            fi
        done
        wait "$others_pid"
        stage "ctest asan+ubsan" count_ctest ctest_stage asan
        stage "golden at -O0" count_ctest ctest_stage debug golden golden
        stage "golden with clang" count_ctest ctest_stage clang golden golden
        stage "threads under tsan" count_ctest ctest_stage tsan threads of_threads
    fi
    [ -z "$late" ] || say "Failed at first and were run once more:$late: see build/test-logs/*-first.log"
    say "Stages"
    printf '%-28s %7s %7s %7s %7s\n%s\n' stage passed failed skipped time "$table"
    if [ "$skipped" -gt 0 ]; then
        echo "$passed passed, $failed failed, $skipped skipped"
    else
        echo "$passed passed, $failed failed"
    fi
    [ "$failed" -eq 0 ]
}

# ---- other verbs ----

run_check() { # [--all]
    local status=0
    install_check
    format_stage || status=1
    spelling_stage || status=1
    node tests/structure/check.mjs . || status=1
    node tests/structure/page.mjs . || status=1
    node tests/structure/page_words.mjs . || status=1
    node tests/structure/lines.mjs . || status=1
    node tests/structure/guides.mjs . || status=1
    node tests/structure/words.mjs . || status=1
    types_stage tsconfig.json || status=1
    types_stage www/report/tsconfig.json || status=1
    types_stage tests/tsconfig.json || status=1
    lint_stage || status=1
    tidy_stage "${1:-}" || status=1
    return $status
}

run_fuzz() { # NAME [SECONDS]
    install_fuzz
    compile fuzz -- --target "fuzz_$1"
    mkdir -p "build/fuzz/corpus/$1"
    build/fuzz/tests/fuzz/"fuzz_$1" -max_total_time="${2:-60}" "build/fuzz/corpus/$1" "tests/fuzz/corpus/$1"
}

# In namespaces of its own: podman's ports and control groups are then nobody else's. crun takes version 1 or 2 of
# these, not both at once.
run_container-test() {
    install_container
    local storage=$PWD/build/containers
    mkdir -p "$storage"
    printf '[storage]\ndriver = "vfs"\nrunroot = "%s/run"\ngraphroot = "%s/root"\n' "$storage" "$storage" >"$storage/storage.conf"
    export CONTAINERS_STORAGE_CONF=$storage/storage.conf BUILDAH_ISOLATION=chroot
    podman image exists localhost/laglab-base || deploy/base-image
    buildah build --layers --format docker --build-arg BASE=localhost/laglab-base -t laglab .
    as_root unshare --mount --net bash -c '
        mount --make-rprivate /
        if [ -d /sys/fs/cgroup/memory ] && mountpoint -q /sys/fs/cgroup/unified; then umount /sys/fs/cgroup/unified; fi
        ip link set lo up
        exec node --test tests/container'
}

run_cross() { # [CPU...]
    local cpu status=0
    install_cross
    for cpu in ${@:-aarch64 riscv64}; do tests/golden/cross.sh "$cpu" all --jobs "$(nproc)" || status=1; done
    return $status
}

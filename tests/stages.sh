# shellcheck shell=bash
# What ./dev test, check, cross, fuzz and container-test do. `dev` reads this and has what installs and builds.
# A stage is a name, a kind and a command, which writes a log; tests/stages.mjs reads the checks from it. The kinds are there.

# ---- running stages ----

logs=build/test-logs running='' lanes=()

# A stage whose log has not grown for so long hangs. It is ended, and has failed. The longest test alone may take 900 s.
stall_s=${LAGLAB_STALL_S:-1200}

end_when_stalled() { # LOG GROUP
    while sleep $((stall_s < 10 ? 1 : 5)); do
        if [ $(($(date +%s) - $(stat -c %Y "$1"))) -ge "$stall_s" ]; then
            echo "ended: nothing was written for $stall_s s" >>"$1"
            kill -TERM -- "-$2"
            sleep 5
            kill -KILL -- "-$2"
        fi
    done
}

stop_stages() {
    trap '' INT TERM
    for group in $running ${lanes[@]+"${lanes[@]}"}; do kill -TERM -- "-$group" 2>/dev/null; done
    wait
    exit 130
}

stage() { # NAME KIND COMMAND...
    local name=$1 kind=$2 log=$logs/${1//[ \/]/-}.log start=$SECONDS status=0 command counts
    shift 2
    rm -f "${log%.log}.xml"
    set -m # each in a group of processes, which ends as one
    { set -e; "$@"; } >"$log" 2>&1 </dev/null &
    command=$!
    end_when_stalled "$log" $command &
    running="$command $!"
    disown # the watch, of whose end nothing is said
    set +m
    wait $command || status=$?
    for group in $running; do kill -KILL -- "-$group" 2>/dev/null; done # the watch, and what the command left
    running=''
    printf '%s\t%s\t%s\t%s\t%s\n' "$name" "$kind" "$log" $status $((SECONDS - start)) >>"$logs/stages.tsv"
    counts=$(node tests/stages.mjs count "$kind" "$log" $status)
    status=$?
    printf '%4d s  %s: %s\n' $((SECONDS - start)) "$name" "$counts"
    [ $status = 0 ] || { tail -n 40 "$log"; return 1; }
}

# Functions of stages, side by side: what mostly waits, and what computes and gives way to it, but not to all else on a busy machine.
in_lane() { # FUNCTION
    lanes=()
    trap stop_stages INT TERM
    "$1"
    : >"$logs/$1.ended"
}
side_by_side() { # FUNCTION...
    local lane
    for lane in "$@"; do
        rm -f "$logs/$lane.ended"
        set -m
        in_lane "$lane" &
        set +m
        lanes+=($!)
    done
    wait "${lanes[@]}"
    lanes=()
    for lane in "$@"; do # what dies between two stages has no row for those that it leaves out
        [ -e "$logs/$lane.ended" ] || printf '%s\tone\t%s\t1\t0\n' "last stage of $lane" none >>"$logs/stages.tsv"
    done
}

run_stages() { # LINE-OF-ARGUMENTS-OF-THE-REPORT FUNCTION...
    local option=$1
    shift
    mkdir -p "$logs"
    : >"$logs/stages.tsv"
    trap stop_stages INT TERM
    set +e
    "$@"
    # shellcheck disable=SC2086 # none or one
    node tests/stages.mjs report "$logs/stages.tsv" $option
}

# ---- stages ----

# Since Linux 6.6 the address space is shuffled more than the thread sanitizer can take.
still_addresses() {
    if setarch -R true 2>/dev/null; then setarch -R "$@"; else "$@"; fi
}

compile_tests() { # PRESET [TARGET...]
    local preset=$1
    shift
    [ $# -eq 0 ] || set -- -- --target "$@"
    compile "$preset" "$@"
}

run_ctest() { # PRESET [OPTION...]
    local folder=build/$1
    [ "$1" != release ] || folder=build
    shift
    # shellcheck disable=SC2154 # the log of the stage
    still_addresses ctest --test-dir "$folder" -j "$(nproc)" --output-on-failure --no-tests=error \
        --output-junit "$PWD/${log%.log}.xml" --test-output-size-passed 1000000 --test-output-size-failed 1000000 "$@"
}

found() { # target | ctest | node, NAME...
    local kind=$1
    shift
    node tests/find.mjs ${all:+--all} "$@" | sed -n "s/^$kind //p"
}

# Tests in another build, which compiles no more than they need. Without names: all.
ctest_stage() { # PRESET [NAME...]
    local preset=$1 targets=() only=()
    shift
    if [ $# -gt 0 ]; then
        mapfile -t targets < <(found target "$@")
        only=(-R "$(found ctest "$@" | paste -sd '|')")
    fi
    compile_tests "$preset" ${targets[@]+"${targets[@]}"} && run_ctest "$preset" -LE '^all$' ${only[@]+"${only[@]}"}
}

program=build/laglab # of node's tests
node_stage() { LAGLAB_BIN=$PWD/$program node tests/run.mjs "$@"; }

structure_stage() {
    local script status=0
    for script in check page page_words lines near guides words; do node "tests/structure/$script.mjs" . || status=1; done
    return $status
}
# The tests use the JavaScript client, which names types that the build makes.
types_stage() {
    local project status=0
    for project in tsconfig.json www/report/tsconfig.json tests/tsconfig.json; do
        [ ! -e "$project" ] || node_modules/.bin/tsc --noEmit -p "$project" || status=1
    done
    return $status
}
# tests/structure/spelling.txt: names and abbreviations that codespell takes for slips
spelling_stage() {
    find . \( -name node_modules -o -name build -o -name .git -o -name corpus -o -name results \) -prune -o -type f \
        \( -name '*.md' -o -name '*.[ch]' -o -name '*.inc' -o -name '*.js' -o -name '*.mjs' -o -name '*.py' -o -name '*.yaml' \
        -o -name '*.json' -o -name '*.sh' -o -name dev \) -not -name 'package-lock.json' -not -path './www/words/de.json' -not -path './www/words/scenarios/*' -not -path './www/words/messages/*' -print0 |
        xargs -0 codespell --quiet-level 3 --ignore-words tests/structure/spelling.txt --ignore-regex '"de": "[^"]*"' # German
}
lint_stage() { node_modules/.bin/biome check --error-on-warnings; } # rules and layout
format_stage() { c_files | xargs -r -P "$(nproc)" -n 100 clang-format-14 --dry-run -Werror; }
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
tidy_stage() { # [--all]
    local files
    if [ "${1:-}" = --all ]; then
        files=$(find src -name '*.c')
    else
        git rev-parse HEAD >/dev/null || { echo "what has changed is not known without git's history"; return 77; }
        files=$(changed_sources)
    fi
    [ -n "$files" ] || { echo "no source of src has changed"; return; }
    printf '%s\n' "$files" | xargs -P "$(nproc)" -n 4 clang-tidy-14 -p build --quiet 2>/dev/null
}

# ---- tiers ----
# A test of tier `all` has the label `all` in ctest, or is a file NAME.all.test.mjs, or is in the folder browsers, cost or container.

all='' # 1: with the tests of that tier
# What reads bytes of strangers: in the default tier, too, under the sanitizers of addresses and of undefined behaviour. What computes
# in these rooms (advice, statistics, links, transitions of a session) comes with all other rooms in tier all.
FOREIGN=(fuzz param record daemon netcode/snapshot link/profile link.table link.profile link.presets
    experiment/spec experiment/format experiment/report experiment/store experiment.work
    session.changes session.failure session.frame session.packed session.session session.timeline session.workload)

gives_way() { renice -n 3 -p "$BASHPID" >/dev/null; }
of_all() { [ -z "$all" ] || stage "$@"; }

units() { stage "units" ctest ctest_stage release; }
api() { stage "api" node node_stage tests/api; }
lint() {
    gives_way
    stage "layout of C" one format_stage
    stage "spelling" one spelling_stage
    stage "types" one types_stage
    stage "lint of JavaScript" one lint_stage
}
structure() { stage "structure" one structure_stage; }
tidy() {
    if [ "$all" ]; then stage "clang-tidy" one tidy_stage --all; else stage "clang-tidy of changes" one tidy_stage; fi
}

sanitize_others() {
    compile_tests asan && run_ctest asan -LE '^all$' -E "$(found ctest "${FOREIGN[@]}" | paste -sd '|')"
}
computing() {
    gives_way
    units
    stage "sanitizers" ctest ctest_stage asan "${FOREIGN[@]}"
    tidy
    of_all "sanitizers of other rooms" ctest sanitize_others
    of_all "units of tier all" ctest run_ctest release -L '^all$'
    of_all "golden at -O0" ctest ctest_stage debug golden
    of_all "golden with clang" ctest ctest_stage clang golden
    of_all "thread sanitizer" ctest ctest_stage tsan daemon threads fluid.team_many rigid.team_many
    [ -z "$all" ] || namespaces || stage "release by a profile" one release --target laglab # else the image is built by it
    of_all "instructions" node node_stage tests/cost
}
waiting() {
    api
    stage "daemon" node node_stage tests/daemon
    stage "page" node node_stage tests/page
    # shellcheck disable=SC2046
    of_all "node tests of tier all" node node_stage --all $(find tests -name '*.all.test.mjs' | sort)
    of_all "browsers" node node_stage tests/browsers
    of_all "container" node container_stage
}

test_fast() {
    if stage "build" one compile_tests release; then side_by_side units api; fi
}
test_tiers() {
    if stage "build" one compile_tests release; then side_by_side computing waiting lint; fi
}
check_all() { side_by_side lint tidy structure; }

# ---- verbs ----

test_some() { # PRESET NAME...
    local preset=$1 log=$logs/some.log targets names name node_files outer=(-LE '^all$')
    shift
    for name in "$@"; do # what is named is run in any tier
        if [[ $name == tests/*.c || $name =~ ^[a-z]+\.[a-z_0-9]+$ ]]; then all=1; fi
    done
    found ctest "$@" >/dev/null || return 2
    mapfile -t targets < <(found target "$@")
    mapfile -t node_files < <(found node "$@")
    names=$(found ctest "$@" | paste -sd '|')
    [ -z "$all" ] || outer=()
    [ "$preset" = release ] || program=build/$preset/laglab
    case " ${node_files[*]} " in
        *.all.test.mjs* | *tests/browsers/* | *tests/cost/* | *tests/container/*) install_all_tests ;;
        *tests/daemon/* | *tests/page/*) install_test ;;
        *mjs*) install_fast ;;
        *) install_build ;;
    esac
    [ ${#node_files[@]} = 0 ] || targets+=(laglab www)
    compile_tests "$preset" ${targets[@]+"${targets[@]}"}
    if [ "$names" ]; then run_ctest "$preset" -R "$names" ${outer[@]+"${outer[@]}"}; fi
    if [ ${#node_files[@]} -gt 0 ]; then node_stage "${node_files[@]}"; fi
}

run_test() { # [--fast | --all] [--record], or [--all] [--debug] NAME...
    local argument fast='' record='' preset=release names=()
    for argument in "$@"; do
        case $argument in
            --fast) fast=1 ;;
            --all) all=1 ;;
            --record) record=--record ;;
            --debug) preset=debug ;;
            -h | --help) help; return ;;
            -*) echo "dev: test takes --fast, --all, --record, --debug, rooms and files; got $argument" >&2; return 2 ;;
            *) names+=("$argument") ;;
        esac
    done
    if [ "$fast" ] && [ "$all" ]; then echo "dev: test takes --fast or --all, not both" >&2; return 2; fi
    mkdir -p "$logs"
    if [ ${#names[@]} -gt 0 ]; then
        [ -z "$fast$record" ] || { echo "dev: --fast and --record are for the tests of all rooms; got ${names[*]}" >&2; return 2; }
        test_some "$preset" "${names[@]}"
    else
        [ "$preset" = release ] || { echo "dev: --debug is for rooms and files: ./dev test --debug link" >&2; return 2; }
        if [ "$all" ]; then install_all_tests; elif [ "$fast" ]; then install_fast; else install_test; fi
        if [ "$fast" ]; then run_stages "$record" test_fast; else run_stages "$record" test_tiers; fi
    fi
}

run_check() { # [--all]
    local types=build/clients/js/types/api.d.ts
    case $* in
        '') ;;
        --all) all=1 ;;
        *) echo "dev: check takes --all or nothing; got $*" >&2; return 2 ;;
    esac
    install_check
    # The types of the JavaScript client are made of the program's description of the API.
    if [ ! -e $types ] || [ -n "$(find api clients/js www/js/stream cmake/api.cmake package-lock.json -newer $types -print -quit)" ]; then
        build --target client_types
    fi
    run_stages "" check_all
}

run_fuzz() { # NAME [SECONDS]
    local names
    names=$(cd tests/fuzz && printf '%s\n' fuzz_*.c | sed 's/^fuzz_\(.*\)\.c$/\1/')
    if ! grep -qxF -- "${1:-}" <<<"$names" || [[ ! ${2:-60} =~ ^[0-9]+$ ]]; then
        echo "dev: fuzz takes one of" $names "and seconds; got ${*:-nothing}" >&2
        return 2
    fi
    install_fuzz
    compile fuzz -- --target "fuzz_$1"
    mkdir -p "build/fuzz/corpus/$1"
    build/fuzz/tests/fuzz/"fuzz_$1" -max_total_time="${2:-60}" "build/fuzz/corpus/$1" "tests/fuzz/corpus/$1"
}

namespaces() { as_root unshare --mount --net true 2>/dev/null; }
# In namespaces of its own: podman's ports and control groups are then nobody else's. crun takes version 1 or 2 of
# these, not both at once.
container_stage() {
    local storage=$PWD/build/containers
    namespaces || { echo "no namespaces here"; return 77; }
    mkdir -p "$storage"
    printf '[storage]\ndriver = "vfs"\nrunroot = "%s/run"\ngraphroot = "%s/root"\n' "$storage" "$storage" >"$storage/storage.conf"
    export CONTAINERS_STORAGE_CONF=$storage/storage.conf BUILDAH_ISOLATION=chroot
    podman image exists localhost/laglab-base || deploy/base-image || return 1
    buildah build --format docker --build-arg BASE=localhost/laglab-base -t laglab . || return 1
    as_root unshare --mount --net bash -c '
        mount --make-rprivate /
        if [ -d /sys/fs/cgroup/memory ] && mountpoint -q /sys/fs/cgroup/unified; then umount /sys/fs/cgroup/unified; fi
        ip link set lo up
        exec node --test tests/container/*.test.mjs'
}

run_container-test() {
    install_container
    container_stage
}

run_cross() { # [CPU...]
    local cpu status=0
    install_cross
    [ $# -gt 0 ] || set -- aarch64 riscv64
    for cpu; do tests/golden/cross.sh "$cpu" all --jobs "$(nproc)" || status=1; done
    return $status
}

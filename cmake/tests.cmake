# tests/ROOM/**/test_NAME.c: a group of the program test_ROOM, an ordinary cmocka program whose main the build renames.
#   Target test_ROOM (test_link = tests/link), program build/tests/ROOM/test_ROOM, ctest name ROOM.NAME (`test_ROOM NAME`), label ROOM.
#   Target tests_ROOM builds what ctest runs of the room, which is also the binary.
# tests/fuzz/fuzz_NAME.c: target fuzz_NAME, a replay of tests/fuzz/corpus/NAME/ (fuzz.NAME), or a libFuzzer with LAGLAB_FUZZ
# tests/cost/frames.c: target cost_frames, whose instructions tests/cost/cost.test.mjs counts
# tests/structure, tests/oracle: scripts
# The label `all`: only `./dev test --all` runs it. Every test runs in the source folder.

set(test_environment "LAGLAB_BIN=${PROJECT_BINARY_DIR}/laglab")
set(tests_dir ${PROJECT_SOURCE_DIR}/tests)
# They are compiled more often than run: -O3 takes 1.5 times as long to compile and changes no test's time.
set(test_options $<$<NOT:$<CONFIG:Debug>>:-O1> $<$<C_COMPILER_ID:GNU>:-Wno-maybe-uninitialized>) # which gcc guesses at -O1

# More of what another test samples (tests/support/many.h).
set(tests_of_many experiment.advise_many fluid.team_many rigid.team_many sim.detection_many sim.outages_many sim.peers_many)
# Published statistics, which only a change of their method can move; other CPUs; more samples.
set(tests_of_all experiment.interval_coverage experiment.interval_runs experiment.until_coverage golden.aarch64 golden.riscv64 oracle.netgame_more
    ${tests_of_many})
# What shares memory between threads, or has the most peers, is run under the sanitizers as much as can be.
if(LAGLAB_SANITIZE)
    list(REMOVE_ITEM tests_of_all fluid.team_many rigid.team_many sim.peers_many)
    list(APPEND tests_of_all fluid.team rigid.team sim.peers)
endif()
# Seconds of the longest, which begin first, so that no core is idle at the end.
set(seconds_of_tests golden.aarch64 40 golden.riscv64 40 experiment.interval_coverage 33 daemon.web_server_stream 28 experiment.advise_many 20
    rigid.team_many 14 daemon.wanted 13 sim.peers_many 13 experiment.advise 12 sim.outages_many 12 rigid.team 9 sim.detection_many 9
    experiment.interval_runs 8 experiment.until_coverage 8 fluid.team_many 8 golden.golden_1 7 golden.golden_2 7 experiment.refinement_series 6
    oracle.netgame_more 6 fluid.team 5 sim.peers 5 experiment.tradeoff 4 sim.detection 3)

file(GLOB support_sources CONFIGURE_DEPENDS ${tests_dir}/support/*.c)
if(support_sources)
    add_library(laglab_test_support STATIC ${support_sources})
    target_compile_definitions(laglab_test_support PRIVATE _GNU_SOURCE)
    target_include_directories(laglab_test_support PUBLIC ${tests_dir})
    target_compile_options(laglab_test_support PRIVATE ${test_options})
    target_link_libraries(laglab_test_support PUBLIC laglab_daemon laglab_engine PkgConfig::CMOCKA)
endif()

# PROGRAM = the sources: linked with the room's libraries, built by tests_ROOM.
function(laglab_test_program program room)
    add_executable(${program} ${ARGN})
    set_target_properties(${program} PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/tests/${room})
    target_compile_definitions(${program} PRIVATE _GNU_SOURCE)
    target_include_directories(${program} PRIVATE ${tests_dir})
    target_link_libraries(${program} PRIVATE $<TARGET_NAME_IF_EXISTS:laglab_test_support>)
    if(room STREQUAL "fuzz")
        target_link_libraries(${program} PRIVATE laglab_cli)
    elseif(room STREQUAL "daemon")
        target_link_libraries(${program} PRIVATE laglab_daemon)
    elseif(room STREQUAL "experiment")
        target_link_libraries(${program} PRIVATE laglab_experiment)
    endif()
    target_link_libraries(${program} PRIVATE laglab_engine PkgConfig::CMOCKA Threads::Threads)
    if(NOT TARGET tests_${room})
        add_custom_target(tests_${room})
        # Some tests start the binary.
        if(TARGET laglab AND NOT room STREQUAL "fuzz")
            add_dependencies(tests_${room} laglab)
        endif()
    endif()
    add_dependencies(tests_${room} ${program})
endfunction()

function(laglab_test name room)
    set(labels ${room})
    if(name IN_LIST tests_of_all)
        list(APPEND labels all)
    endif()
    set(seconds 0)
    list(FIND seconds_of_tests ${name} at)
    if(NOT at EQUAL -1)
        math(EXPR at "${at} + 1")
        list(GET seconds_of_tests ${at} seconds)
    endif()
    add_test(NAME ${name} COMMAND ${ARGN} WORKING_DIRECTORY ${PROJECT_SOURCE_DIR})
    set_tests_properties(${name} PROPERTIES LABELS "${labels}" TIMEOUT 900 COST ${seconds} ENVIRONMENT "${test_environment}")
endfunction()

# ---- unit tests, mirroring src ----
file(GLOB_RECURSE test_sources CONFIGURE_DEPENDS ${tests_dir}/test_*.c)
set(test_rooms "")
foreach(source IN LISTS test_sources)
    file(RELATIVE_PATH room ${tests_dir} ${source})
    string(REGEX REPLACE "/.*" "" room ${room})
    get_filename_component(name ${source} NAME_WE)
    string(REGEX REPLACE "^test_" "" name ${name})
    set_source_files_properties(${source} PROPERTIES
        COMPILE_DEFINITIONS GROUP=test_group_${name}
        COMPILE_OPTIONS "-include;${tests_dir}/support/program/group.h")
    list(APPEND test_rooms ${room})
    list(APPEND sources_of_${room} ${source})
    string(APPEND groups_of_${room} "GROUP(${name})\n")
    if(room STREQUAL "golden" AND name STREQUAL "golden") # two cores share it
        laglab_test(golden.golden_1 golden test_golden golden 1/2)
        laglab_test(golden.golden_2 golden test_golden golden 2/2)
    else()
        laglab_test(${room}.${name} ${room} test_${room} ${name})
    endif()
endforeach()
foreach(name IN LISTS tests_of_many)
    if(name MATCHES "^([a-z]+)\\.(.+)_many$")
        laglab_test(${name} ${CMAKE_MATCH_1} test_${CMAKE_MATCH_1} ${CMAKE_MATCH_2} many)
    endif()
endforeach()
list(REMOVE_DUPLICATES test_rooms)
foreach(room IN LISTS test_rooms)
    set(groups ${PROJECT_BINARY_DIR}/tests/${room}/groups.inc)
    file(CONFIGURE OUTPUT ${groups} CONTENT "${groups_of_${room}}")
    add_library(test_main_of_${room} OBJECT ${tests_dir}/support/program/main.c)
    target_compile_definitions(test_main_of_${room} PRIVATE "GROUPS=\"${groups}\"")
    laglab_test_program(test_${room} ${room} ${sources_of_${room}} $<TARGET_OBJECTS:test_main_of_${room}>)
    target_compile_options(test_${room} PRIVATE ${test_options})
endforeach()

# ---- what a frame costs ----
laglab_test_program(cost_frames cost ${tests_dir}/cost/frames.c)

# ---- fuzzing ----
file(GLOB fuzz_sources CONFIGURE_DEPENDS ${tests_dir}/fuzz/fuzz_*.c)
if(NOT LAGLAB_FUZZ)
    add_library(laglab_test_replay OBJECT ${tests_dir}/fuzz/replay.c)
    target_compile_definitions(laglab_test_replay PRIVATE _GNU_SOURCE)
    target_compile_options(laglab_test_replay PRIVATE ${test_options})
endif()
foreach(source IN LISTS fuzz_sources)
    get_filename_component(program ${source} NAME_WE)
    string(REGEX REPLACE "^fuzz_" "" name ${program})
    laglab_test_program(${program} fuzz ${source})
    # libFuzzer's entry has no header that declares it.
    target_compile_options(${program} PRIVATE -Wno-missing-prototypes)
    if(LAGLAB_FUZZ)
        target_link_options(${program} PRIVATE -fsanitize=fuzzer)
        laglab_test(fuzz.${name} fuzz ${program} -runs=0 ${tests_dir}/fuzz/corpus/${name})
    else()
        target_link_libraries(${program} PRIVATE laglab_test_replay)
        target_compile_options(${program} PRIVATE ${test_options})
        laglab_test(fuzz.${name} fuzz ${program} ${tests_dir}/fuzz/corpus/${name})
    endif()
endforeach()

# ---- other CPUs, emulated: a sample; 77 and the reason where it cannot be run ----
if(PROJECT_IS_TOP_LEVEL AND NOT CMAKE_BUILD_TYPE STREQUAL "Debug" AND NOT LAGLAB_SANITIZE AND CMAKE_C_COMPILER_ID STREQUAL "GNU")
    foreach(cpu IN ITEMS aarch64 riscv64)
        laglab_test(golden.${cpu} golden ${tests_dir}/golden/cross.sh ${cpu} sample)
        set_tests_properties(golden.${cpu} PROPERTIES SKIP_RETURN_CODE 77)
    endforeach()
endif()

# ---- structure ----
find_program(NODE_PROGRAM NAMES node nodejs)
if(NODE_PROGRAM)
    laglab_test(structure.rooms structure ${NODE_PROGRAM} tests/structure/check.mjs .)
    laglab_test(structure.selftest structure ${NODE_PROGRAM} tests/structure/selftest.mjs)
    laglab_test(structure.page structure ${NODE_PROGRAM} tests/structure/page.mjs .)
    laglab_test(structure.page_selftest structure ${NODE_PROGRAM} tests/structure/page_selftest.mjs)
    laglab_test(structure.page_words structure ${NODE_PROGRAM} tests/structure/page_words.mjs .)
    laglab_test(structure.page_words_selftest structure ${NODE_PROGRAM} tests/structure/page_words_selftest.mjs)
    laglab_test(structure.lines structure ${NODE_PROGRAM} tests/structure/lines.mjs .)
    laglab_test(structure.lines_selftest structure ${NODE_PROGRAM} tests/structure/lines_selftest.mjs)
    laglab_test(structure.near structure ${NODE_PROGRAM} tests/structure/near.mjs .)
    laglab_test(structure.near_selftest structure ${NODE_PROGRAM} tests/structure/near_selftest.mjs)
    laglab_test(structure.guides structure ${NODE_PROGRAM} tests/structure/guides.mjs .)
    laglab_test(structure.guides_selftest structure ${NODE_PROGRAM} tests/structure/guides_selftest.mjs)
    laglab_test(structure.words structure ${NODE_PROGRAM} tests/structure/words.mjs .)
    laglab_test(structure.words_selftest structure ${NODE_PROGRAM} tests/structure/words_selftest.mjs)
    laglab_test(structure.stages_selftest structure ${NODE_PROGRAM} tests/structure/stages_selftest.mjs)
    laglab_test(structure.mutate_selftest structure ${NODE_PROGRAM} tests/structure/mutate_selftest.mjs)
    laglab_test(structure.version structure ${NODE_PROGRAM} tests/structure/version.mjs ${PROJECT_BINARY_DIR})
else()
    message(WARNING "node was not found: the structure tests are left out")
endif()

# ---- a second program, from the docs alone ----
find_program(PYTHON_PROGRAM NAMES python3)
if(PYTHON_PROGRAM AND TARGET laglab)
    laglab_test(oracle.netgame oracle ${PYTHON_PROGRAM} tests/oracle/run.py --count 50 --seed 1)
    laglab_test(oracle.netgame_more oracle ${PYTHON_PROGRAM} tests/oracle/run.py --count 100 --seed 2)
    laglab_test(oracle.more oracle ${PYTHON_PROGRAM} tests/oracle/run.py --more --count 25 --seed 1)
    file(GLOB FOUND RELATIVE ${CMAKE_SOURCE_DIR}/tests/oracle/found CONFIGURE_DEPENDS tests/oracle/found/*.json)
    foreach(name IN LISTS FOUND) # scenarios in which both once differed
        string(REPLACE ".json" "" name ${name})
        laglab_test(oracle.${name} oracle ${PYTHON_PROGRAM} tests/oracle/run.py --one tests/oracle/found/${name}.json)
    endforeach()
else()
    message(WARNING "python3 was not found: the oracle is left out")
endif()

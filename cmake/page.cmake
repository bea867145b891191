# Copies www/ and scenarios/ from SOURCE to BINARY, and the page's libraries from node_modules to www/vendor/.
# Run with cmake -DSOURCE=... -DBINARY=... [-DTYPES=FOLDER] -P page.cmake; TYPES: those of the JavaScript client

set(modules ${SOURCE}/node_modules)
set(vendor ${BINARY}/www/vendor)

foreach(folder IN ITEMS www scenarios)
    file(REMOVE_RECURSE ${BINARY}/${folder})
    if(IS_DIRECTORY ${SOURCE}/${folder})
        file(COPY ${SOURCE}/${folder} DESTINATION ${BINARY} REGEX "/www/report$" EXCLUDE) # that is in the program
    endif()
endforeach()

# What a list of lessons shows of each, so that a page reads one file for it.
file(GLOB lessons ${BINARY}/www/lessons/*.json)
set(index "[]")
set(count 0)
foreach(lesson IN LISTS lessons)
    get_filename_component(id ${lesson} NAME_WE)
    file(READ ${lesson} text)
    set(entry "{}")
    string(JSON entry SET "${entry}" id "\"${id}\"")
    foreach(member IN ITEMS order topic title paper scenario minutes age prerequisites hooks)
        string(JSON type ERROR_VARIABLE missing TYPE "${text}" ${member})
        if(missing)
            continue()
        endif()
        string(JSON value GET "${text}" ${member})
        if(type STREQUAL "STRING")
            set(value "\"${value}\"")
        endif()
        string(JSON entry SET "${entry}" ${member} "${value}")
    endforeach()
    string(JSON index SET "${index}" ${count} "${entry}")
    math(EXPR count "${count} + 1")
endforeach()
if(count GREATER 0)
    file(WRITE ${BINARY}/www/lessons/index.json "${index}\n")
endif()

# The words of each language in the parts that a page reads: those of the page itself, of the lessons, of a class, of each lab. The names of
# parameters, metrics and units come with the lab that shows them: of a netgame those on its panels, the rest with its dialogs, and the
# metrics with experiments. A first load is measured in bytes: indents go.
function(write_words part text)
    string(REGEX REPLACE "\n[\t ]+" "\n" text "${text}")
    string(REGEX REPLACE "\n(\"[^\"]*\") : " "\n\\1:" text "${text}")
    file(WRITE ${BINARY}/www/words/${part}.json "${text}\n")
endfunction()

# Members of an object whose names match a pattern.
function(pick result object pattern)
    set(picked "{}")
    string(JSON last LENGTH "${object}")
    math(EXPR last "${last} - 1")
    foreach(index RANGE ${last})
        string(JSON name MEMBER "${object}" ${index})
        if(name MATCHES "${pattern}")
            string(JSON type TYPE "${object}" "${name}")
            string(JSON value GET "${object}" "${name}")
            if(type STREQUAL "STRING")
                set(value "\"${value}\"")
            endif()
            string(JSON picked SET "${picked}" "${name}" "${value}")
        endif()
    endforeach()
    set(${result} "${picked}" PARENT_SCOPE)
endfunction()

set(on_panels "^(server\\.(update_hz|sync)|players\\.\\*\\.(lag_ms|prediction|reconciliation|interpolation|control|link\\.\\*\\.(jitter_ms|loss_pct)))(\\.[a-z_]+)?$")

file(GLOB languages ${BINARY}/www/words/*.json)
foreach(language IN LISTS languages)
    get_filename_component(name ${language} NAME_WE)
    file(READ ${language} text)
    foreach(part IN ITEMS page lesson class)
        string(JSON words GET "${text}" ${part})
        write_words(${name}/${part} "{\"words\": ${words}}")
    endforeach()
    string(JSON words GET "${text}" packet)
    write_words(packet/${name} "${words}")
    foreach(part IN ITEMS units params choices metrics)
        string(JSON ${part} GET "${text}" ${part})
    endforeach()

    string(JSON words GET "${text}" netgame)
    pick(values "${metrics}" "^players\\.\\*\\.game\\.")
    string(JSON last LENGTH "${values}")
    math(EXPR last "${last} - 1")
    foreach(index RANGE ${last})
        string(JSON path MEMBER "${values}" ${index})
        string(JSON label GET "${values}" "${path}" label)
        string(REPLACE "players.*.game." "netgame.value." path "${path}")
        string(JSON words SET "${words}" "${path}" "\"${label}\"")
    endforeach()
    pick(shown "${params}" "${on_panels}")
    pick(chosen "${choices}" "${on_panels}")
    write_words(${name}/netgame "{\"words\": ${words}, \"params\": ${shown}, \"choices\": ${chosen}}")
    string(JSON words GET "${text}" netgame_more)
    write_words(${name}/netgame_more "{\"words\": ${words}, \"params\": ${params}, \"choices\": ${choices}, \"units\": ${units}}")
    write_words(${name}/netgame_metrics "{\"words\": {}, \"metrics\": ${metrics}}")
    string(JSON words GET "${text}" experiments)
    write_words(${name}/experiments "{\"words\": ${words}, \"units\": ${units}}")
    string(JSON words GET "${text}" tradeoff)
    write_words(${name}/tradeoff "{\"words\": ${words}}")

    foreach(part IN ITEMS motion rigid fluid)
        string(JSON words GET "${text}" ${part})
        string(JSON inputs GET "${text}" inputs ${part})
        string(JSON measured GET "${text}" labs ${part})
        string(JSON choices GET "${text}" names ${part})
        write_words(${name}/${part}
            "{\"words\": ${words}, \"params\": ${inputs}, \"metrics\": ${measured}, \"choices\": ${choices}, \"units\": ${units}}")
    endforeach()
endforeach()

# What the program ships of speed against error.
execute_process(COMMAND node ${SOURCE}/cmake/shipped_rows.mjs ${SOURCE}/bench/results/tradeoff ${BINARY}/www/tradeoffs
    COMMAND_ERROR_IS_FATAL ANY)

# The clients that a daemon serves, for a room without Internet.
execute_process(COMMAND python3 ${SOURCE}/clients/python/wheel.py ${BINARY}/www/clients COMMAND_ERROR_IS_FATAL ANY OUTPUT_QUIET)
execute_process(COMMAND python3 ${SOURCE}/clients/js/pack.py ${BINARY}/www/clients ${TYPES} COMMAND_ERROR_IS_FATAL ANY OUTPUT_QUIET)
file(COPY ${SOURCE}/clients/python/examples/techniques.ipynb ${SOURCE}/clients/r/techniques.R ${SOURCE}/clients/r/techniques.json
    DESTINATION ${BINARY}/www/clients)
# Of JavaScript also the modules themselves, for pages: what they share with this page stands elsewhere than in the sources.
file(GLOB client_modules ${SOURCE}/clients/js/*.js)
foreach(module IN LISTS client_modules)
    get_filename_component(name ${module} NAME)
    file(READ ${module} text)
    string(REPLACE "../../www/js/" "../../js/" text "${text}")
    file(WRITE ${BINARY}/www/clients/js/${name} "${text}")
endforeach()

# Modules go without their lines of comment, which have the types too: a quarter of a first load, which is measured in bytes.
file(GLOB_RECURSE own ${BINARY}/www/js/*.js)
foreach(module IN LISTS own)
    file(READ ${module} text)
    string(REGEX REPLACE "\n[\t ]*/[*][*][^*]*[*]+([^/*][^*]*[*]+)*/\n" "\n" text "\n${text}")
    string(REGEX REPLACE "\n[\t ]*/[*][*][^*]*[*]+([^/*][^*]*[*]+)*/\n" "\n" text "${text}") # of two in succession the second
    string(REGEX REPLACE "\n[\t ]*//[^\n]*" "" text "${text}")
    string(REGEX REPLACE "/[*][*] @type [^*]*[*]/ ?" "" text "${text}") # of an expression, within a line
    string(REGEX REPLACE "[\t ]*/[*] [^*\n]*[*]/\n" "\n" text "${text}") # at the end of a line
    file(WRITE ${module} "${text}")
endforeach()

# Indents go, since a first load is measured in bytes; lines keep their numbers.
file(GLOB_RECURSE own ${BINARY}/www/js/*.js ${BINARY}/www/*.css)
foreach(file IN LISTS own)
    file(READ ${file} text)
    string(REGEX REPLACE "\n[\t ]+" "\n" text "${text}")
    file(WRITE ${file} "${text}")
endforeach()

# Indents, empty lines and lines of comment go: a first load is measured in bytes. So does the comment that names the source map, which is
# not shipped and which a browser's console would miss.
function(vendor_file from to)
    if(NOT EXISTS ${modules}/${from})
        message(FATAL_ERROR "node_modules/${from} is missing: run `npm ci --ignore-scripts` (./dev build does)")
    endif()
    file(READ ${modules}/${from} text)
    string(REGEX REPLACE "\n[\t ]+" "\n" text "${text}")
    string(REGEX REPLACE "\n//[^\n]*" "" text "${text}")
    string(REGEX REPLACE "\n\n+" "\n" text "${text}")
    file(WRITE ${vendor}/${to} "${text}")
endfunction()

vendor_file(lit-html/lit-html.js lit-html.js)
vendor_file(@preact/signals-core/dist/signals-core.mjs signals-core.js)
vendor_file(lean-qr/index.mjs lean-qr.js)
vendor_file(uplot/dist/uPlot.iife.min.js uplot.js)
file(APPEND ${vendor}/uplot.js "\nexport default uPlot;\n") # the package's modules are not minified
vendor_file(uplot/dist/uPlot.min.css uplot.css)

file(WRITE ${vendor}/LICENSES.txt "The libraries in this folder and their licences.\n")
foreach(package IN ITEMS lit-html @preact/signals-core lean-qr uplot)
    file(READ ${modules}/${package}/package.json manifest)
    string(JSON version GET "${manifest}" version)
    file(READ ${modules}/${package}/LICENSE licence)
    file(APPEND ${vendor}/LICENSES.txt "\n==== ${package} ${version} ====\n\n${licence}")
endforeach()

# Copies www/, scenarios/ and api/ from SOURCE to BINARY, and the page's libraries from node_modules to www/vendor/.
# Run with cmake -DSOURCE=... -DBINARY=... -P page.cmake

set(modules ${SOURCE}/node_modules)
set(vendor ${BINARY}/www/vendor)

foreach(folder IN ITEMS www scenarios api)
    file(REMOVE_RECURSE ${BINARY}/${folder})
    if(IS_DIRECTORY ${SOURCE}/${folder})
        file(COPY ${SOURCE}/${folder} DESTINATION ${BINARY})
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

# What the lessons' part of the page has of each language: the rest is six times as much.
file(GLOB languages ${BINARY}/www/words/*.json)
foreach(language IN LISTS languages)
    get_filename_component(name ${language} NAME)
    file(READ ${language} text)
    string(JSON words GET "${text}" lesson)
    file(WRITE ${BINARY}/www/lessons/words/${name} "${words}\n")
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

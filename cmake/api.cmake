# Copies api/ from SOURCE to BINARY and writes what the program LAGLAB prints of it: the schemas to which openapi.yaml refers, and the schema
# of scenarios. What is the same stays as it is. Without LAGLAB, which cannot run on every machine that builds it, they are left out.
# Run with cmake -DSOURCE=... -DBINARY=... [-DLAGLAB=PROGRAM] -P api.cmake

file(GLOB names RELATIVE ${SOURCE}/api ${SOURCE}/api/*)
foreach(name IN LISTS names)
    file(COPY_FILE ${SOURCE}/api/${name} ${BINARY}/api/${name} ONLY_IF_DIFFERENT)
endforeach()

function(print name)
    list(APPEND names ${name})
    set(names ${names} PARENT_SCOPE)
    set(file ${BINARY}/api/${name})
    execute_process(COMMAND ${LAGLAB} schema ${ARGN} OUTPUT_FILE ${file}.new COMMAND_ERROR_IS_FATAL ANY)
    file(COPY_FILE ${file}.new ${file} ONLY_IF_DIFFERENT)
    file(REMOVE ${file}.new)
endfunction()

if(LAGLAB)
    print(schemas.json all)
    print(scenario.schema.json)
endif()

file(GLOB there RELATIVE ${BINARY}/api ${BINARY}/api/*)
list(REMOVE_ITEM there ${names})
foreach(name IN LISTS there)
    file(REMOVE ${BINARY}/api/${name})
endforeach()

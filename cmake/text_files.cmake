# Writes text files into a C source as constants, so that the program needs no file beside it.
# Run with cmake -DOUTPUT=FILE.c -DHEADER=... "-DFILES=NAME=FILE;NAME=FILE" -P text_files.cmake
set(source "#include \"${HEADER}\"\n")
string(REPLACE "," ";" FILES "${FILES}")
foreach(pair IN LISTS FILES)
    string(REGEX MATCH "^([^=]*)=(.*)$" unused "${pair}")
    set(name ${CMAKE_MATCH_1})
    file(READ ${CMAKE_MATCH_2} bytes HEX)
    string(REGEX REPLACE "([0-9a-f][0-9a-f])" "'\\\\x\\1'," bytes "${bytes}")
    string(REPLACE "'\\x0a'," "'\\x0a',\n" bytes "${bytes}")
    string(APPEND source "const char ${name}[] = {\n${bytes}0};\n")
endforeach()
file(WRITE ${OUTPUT} "${source}")

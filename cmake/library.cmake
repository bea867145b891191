# The engine as a C library: include/laglab.h, static and shared, with a pkg-config file and the scenarios.
#
#   cmake --build build --target liblaglab && cmake --install build --prefix PREFIX

include(GNUInstallDirs)

file(GLOB embed_sources CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/src/embed/*.c)
laglab_library(laglab_embed ${embed_sources})
target_include_directories(laglab_embed PRIVATE ${PROJECT_SOURCE_DIR}/include)
target_compile_options(laglab_embed PRIVATE -fPIE)
target_link_libraries(laglab_embed PRIVATE laglab_engine laglab_experiment)

# One object with everything that these functions need. Names that the header does not have become local to it: a program may have
# functions of the same names, and references to them need no table of addresses in the shared library.
set(embed_folder ${PROJECT_BINARY_DIR}/embed)
set(embed_object ${embed_folder}/laglab.o)
add_custom_command(
    OUTPUT ${embed_object}
    COMMAND ${CMAKE_COMMAND} -E make_directory ${embed_folder}
    COMMAND ${CMAKE_C_COMPILER} -r -nostdlib -o ${embed_folder}/all.o
            -Wl,--whole-archive $<TARGET_FILE:laglab_embed> -Wl,--no-whole-archive
            $<TARGET_FILE:laglab_experiment> $<TARGET_FILE:laglab_engine>
    COMMAND ${CMAKE_OBJCOPY} --wildcard --keep-global-symbol=laglab_* --strip-debug ${embed_folder}/all.o ${embed_object}
    COMMAND ${CMAKE_COMMAND} -E rm ${embed_folder}/all.o
    DEPENDS laglab_embed laglab_experiment laglab_engine
    COMMENT "Linking the C library"
    VERBATIM)
set_source_files_properties(${embed_object} PROPERTIES EXTERNAL_OBJECT ON GENERATED ON)
add_custom_target(laglab_embed_object DEPENDS ${embed_object})

add_library(laglab_static STATIC ${embed_object})
add_library(laglab_shared SHARED ${embed_object})
foreach(target IN ITEMS laglab_static laglab_shared)
    set_target_properties(${target} PROPERTIES OUTPUT_NAME laglab LINKER_LANGUAGE C)
    add_dependencies(${target} laglab_embed_object)
endforeach()
# Before 1.0 each minor release may change the interface.
set_target_properties(laglab_shared PROPERTIES
    VERSION ${PROJECT_VERSION} SOVERSION ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR})
target_link_options(laglab_shared PRIVATE -Wl,-z,defs)
target_link_libraries(laglab_shared PRIVATE PkgConfig::CJSON PkgConfig::ZLIB Threads::Threads m)
add_custom_target(liblaglab DEPENDS laglab_static laglab_shared)

# Relative to the file, so that an installed folder may be moved.
file(RELATIVE_PATH to_prefix /${CMAKE_INSTALL_LIBDIR}/pkgconfig /)
file(CONFIGURE OUTPUT ${embed_folder}/laglab.pc @ONLY CONTENT [[prefix=${pcfiledir}/@to_prefix@
includedir=${prefix}/@CMAKE_INSTALL_INCLUDEDIR@
libdir=${prefix}/@CMAKE_INSTALL_LIBDIR@
scenarios=${prefix}/@CMAKE_INSTALL_DATADIR@/laglab/scenarios

Name: laglab
Description: A laboratory for game physics under lag: runs scenarios and reads what they measure
Version: @PROJECT_VERSION@
Cflags: -I${includedir}
Libs: -L${libdir} -llaglab
Libs.private: -lcjson -lz -lm -pthread
]])

install(TARGETS laglab_static laglab_shared
    ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(FILES ${PROJECT_SOURCE_DIR}/include/laglab.h DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
install(FILES ${embed_folder}/laglab.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
install(DIRECTORY ${PROJECT_SOURCE_DIR}/scenarios DESTINATION ${CMAKE_INSTALL_DATADIR}/laglab)

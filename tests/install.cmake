# Installs the build into an empty folder, cooks with the installed program what reads a mesh (which a
# second program does) and draws it, and builds a program that uses the libraries.
#   cmake -DBUILD=... -DSOURCE=... -DWORK=... -P tests/install.cmake
cmake_minimum_required(VERSION 3.25)
file(REMOVE_RECURSE ${WORK})
file(MAKE_DIRECTORY ${WORK})

function(run name)
  execute_process(COMMAND ${ARGN} WORKING_DIRECTORY ${WORK} RESULT_VARIABLE failed OUTPUT_VARIABLE out
    ERROR_VARIABLE out)
  if(failed)
    message(FATAL_ERROR "${name} failed (${failed}):\n${out}")
  endif()
endfunction()

run("installing" ${CMAKE_COMMAND} --install ${BUILD} --prefix ${WORK}/installed)
foreach(file bin/aspic libexec/aspic/aspic-assimp share/man/man1/aspic.1
    share/bash-completion/completions/aspic share/aspic/graphs/chair.json share/doc/aspic/LICENSE)
  if(NOT EXISTS ${WORK}/installed/${file})
    message(FATAL_ERROR "${file} was not installed")
  endif()
endforeach()
if(EXISTS ${BUILD}/aspic-openvdb AND NOT EXISTS ${WORK}/installed/libexec/aspic/aspic-openvdb)
  message(FATAL_ERROR "aspic-openvdb was not installed")
endif()
run("cooking with the installed program" ${WORK}/installed/bin/aspic cook
  ${WORK}/installed/share/aspic/graphs/chair.json --frames 1 --no-disk-cache --out ${WORK}/out)
file(GLOB pictures ${WORK}/out/frames/*.png)
if(NOT pictures)
  message(FATAL_ERROR "the installed program wrote no picture")
endif()
run("configuring a user's program" ${CMAKE_COMMAND} -S ${SOURCE}/tests/install -B user -G Ninja
  -DCMAKE_PREFIX_PATH=${WORK}/installed)
run("building a user's program" ${CMAKE_COMMAND} --build user)
run("running a user's program" ${WORK}/user/user_of_aspic)

# The man page and the completion know every command.
execute_process(COMMAND ${WORK}/installed/bin/aspic --help OUTPUT_VARIABLE help)
file(READ ${SOURCE}/packaging/aspic.1 page)
string(REGEX MATCHALL "\n  [a-z]+  " commands "${help}")
foreach(command ${commands})
  string(STRIP "${command}" command)
  if(NOT page MATCHES "[^a-z]${command}[^a-z]")
    message(FATAL_ERROR "the man page (packaging/aspic.1) does not know '${command}'")
  endif()
endforeach()
execute_process(COMMAND bash -c "PATH=${WORK}/installed/bin:$PATH; . '${WORK}/installed/share/bash-completion/completions/aspic'; COMP_WORDS=(aspic coo) COMP_CWORD=1; _aspic; echo \"\${COMPREPLY[*]}\"; COMP_WORDS=(aspic cook --fra) COMP_CWORD=2; _aspic; echo \"\${COMPREPLY[*]}\""
  OUTPUT_VARIABLE completed)
if(NOT completed STREQUAL "cook\n--frames\n")
  message(FATAL_ERROR "shell completion gave:\n${completed}")
endif()

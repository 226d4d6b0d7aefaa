# stillgrid_npm(FOLDER): a rule that makes FOLDER/fetched.stamp, when FOLDER/node_modules holds what the
# package.json and the lock beside the caller's CMakeLists.txt name. It runs when one of the two changes.
function(stillgrid_npm folder)
  set(lists ${CMAKE_CURRENT_SOURCE_DIR}/package.json ${CMAKE_CURRENT_SOURCE_DIR}/package-lock.json)
  set(failed "npm could not fetch what ${CMAKE_CURRENT_SOURCE_DIR}/package-lock.json names: see ${folder}/npm.log")
  add_custom_command(OUTPUT ${folder}/fetched.stamp
    COMMAND ${CMAKE_COMMAND} -E make_directory ${folder}
    COMMAND ${CMAKE_COMMAND} -E copy ${lists} ${folder}
    COMMAND sh -c "cd \"$1\" && \"$2\" ci --include=dev --no-audit --no-fund --prefer-offline >npm.log 2>&1 || { echo \"$3\" >&2; exit 1; }"
      sh ${folder} ${STILLGRID_NPM} ${failed}
    COMMAND ${CMAKE_COMMAND} -E touch ${folder}/fetched.stamp
    DEPENDS ${lists}
    COMMENT "npm: ${folder}"
    VERBATIM)
endfunction()

# cmake -D URL=... -D FILE=... [-D SHA256=...] -P download.cmake
# CMake is there on every machine that builds DEFE; curl and wget may not be.
if(SHA256)
  file(DOWNLOAD "${URL}" "${FILE}" EXPECTED_HASH "SHA256=${SHA256}" TLS_VERIFY ON STATUS status)
else()
  file(DOWNLOAD "${URL}" "${FILE}" TLS_VERIFY ON STATUS status)
endif()
list(GET status 0 code)
if(code)
  list(GET status 1 text)
  file(REMOVE "${FILE}")
  message(FATAL_ERROR "Download of ${URL} failed: ${text}")
endif()

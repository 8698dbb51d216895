/* The C face of OpenColorIO that bindgen reads; ocio_shim.cpp implements it. No C++ exception crosses it. */
#ifndef SUNDOG_OCIO_SHIM_H
#define SUNDOG_OCIO_SHIM_H

#ifdef __cplusplus
extern "C" {
#endif

/* The version of the OpenColorIO library that is loaded, as "2.6.0". Owned by the library; never null. */
const char *sundog_ocio_version(void);

#ifdef __cplusplus
}
#endif

#endif

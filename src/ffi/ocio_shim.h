/* A small C face over OpenColorIO's C++ API: what Sundog asks of it and no more. bindgen reads this file.
 *
 * Rules that hold for every function:
 * - No C++ exception leaves. A function that can fail returns false and puts a text into *error (or NULL there if
 *   there was no memory for one); the caller gives it back to sundog_ocio_text_free.
 * - Every `char *` that comes out belongs to the caller: sundog_ocio_text_free, or the *_free of the struct it is in.
 *   Every `const char *` that goes in is only read during the call. Texts are UTF-8 as far as OpenColorIO's are.
 * - Functions that take a SundogOcioConfig may be called by one thread at a time only: OpenColorIO fills some of its
 *   caches in const functions without a lock. sundog_ocio_apply may be called by any number of threads at a time. */
#ifndef SUNDOG_OCIO_SHIM_H
#define SUNDOG_OCIO_SHIM_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Goes up with every change of a struct or of a function's arguments. */
#define SUNDOG_OCIO_ABI_VERSION 1

/* A configuration, and a chain of colour operations ready to be applied to pixels. */
typedef struct SundogOcioConfig SundogOcioConfig;
typedef struct SundogOcioProcessor SundogOcioProcessor;

/* What the shim was compiled with and what it runs with. Versions are as OCIO_VERSION_HEX: 0x02060000 is 2.6.0. */
typedef struct SundogOcioAbi {
    uint32_t abi_version;
    uint32_t role_size;
    uint32_t colour_space_size;
    uint32_t view_size;
    uint32_t look_size;
    uint32_t display_size;
    uint32_t headers_version;
    uint32_t library_version;
} SundogOcioAbi;

typedef struct SundogOcioRole {
    char *name;
    char *colour_space;
} SundogOcioRole;

typedef struct SundogOcioColourSpace {
    char *name;
    char *family;
    char *encoding;
    char *description;
    bool is_data;
    /* Its reference is a display's light rather than the scene's. */
    bool is_display_referred;
} SundogOcioColourSpace;

/* Fields that the configuration does not give are empty texts. */
typedef struct SundogOcioView {
    char *name;
    char *colour_space;
    char *view_transform;
    /* Looks that the configuration itself ties to the view, in OpenColorIO's notation. */
    char *looks;
    char *description;
} SundogOcioView;

typedef struct SundogOcioLook {
    char *name;
    char *process_space;
    char *description;
} SundogOcioLook;

/* What sundog_ocio_display_processor is to make. */
typedef struct SundogOcioDisplay {
    /* The pixels are in the scene_linear space; if not, they are linear Rec.709 and are brought there first. */
    bool from_scene_linear;
    const char *display;
    const char *view;
    /* In OpenColorIO's notation; NULL: only what the view itself brings along. */
    const char *look;
    /* Multiplied onto scene-linear light: 2^exposure. */
    double scale;
    /* Display values are raised to this power: 1/gamma. */
    double exponent;
    /* Multiplied onto the display's light at the end; not 1 only for views that end in a display-referred space of a
     * configuration with the role cie_xyz_d65_interchange. */
    double display_scale;
} SundogOcioDisplay;

/* Writes what struct_size says there is room for: false, and nothing written, if that is not the shim's own size. */
bool sundog_ocio_abi(SundogOcioAbi *abi, size_t struct_size);

void sundog_ocio_text_free(char *text);

/* Warnings that OpenColorIO wrote since the last call, a line each; NULL if there are none. From the first call of any
 * function that makes a configuration, they no longer go to the standard error. */
char *sundog_ocio_take_log(void);

/* A file (.ocio, .ocioz), or a configuration inside the library under its `ocio://` name. */
SundogOcioConfig *sundog_ocio_config_from_file(const char *path_or_uri, char **error);
/* The text of a .ocio file, without the files that it may refer to. */
SundogOcioConfig *sundog_ocio_config_from_text(const char *text, size_t length, char **error);
/* OpenColorIO's own fall-back: one "raw" space and nothing else. */
SundogOcioConfig *sundog_ocio_config_raw(char **error);
void sundog_ocio_config_free(SundogOcioConfig *config);

bool sundog_ocio_config_name(const SundogOcioConfig *config, char **name, char **error);
bool sundog_ocio_config_description(const SundogOcioConfig *config, char **description, char **error);
/* Major and minor version of the configuration's format. */
bool sundog_ocio_config_profile(const SundogOcioConfig *config, uint32_t *major, uint32_t *minor, char **error);

/* The files that the configuration's transforms refer to, as far as they are there: a path a line. None is opened. */
bool sundog_ocio_config_files(const SundogOcioConfig *config, char **paths, char **error);

bool sundog_ocio_role_count(const SundogOcioConfig *config, size_t *count, char **error);
bool sundog_ocio_role(const SundogOcioConfig *config, size_t index, SundogOcioRole *role, char **error);
void sundog_ocio_role_free(SundogOcioRole *role);

/* Active colour spaces only; sundog_ocio_has_colour_space knows them all, and roles and aliases. */
bool sundog_ocio_colour_space_count(const SundogOcioConfig *config, size_t *count, char **error);
bool sundog_ocio_colour_space(const SundogOcioConfig *config, size_t index, SundogOcioColourSpace *space, char **error);
void sundog_ocio_colour_space_free(SundogOcioColourSpace *space);
bool sundog_ocio_has_colour_space(const SundogOcioConfig *config, const char *name, bool *has, char **error);

/* Active displays and views, in the configuration's order. The default ones are empty texts where there are none. */
bool sundog_ocio_display_count(const SundogOcioConfig *config, size_t *count, char **error);
bool sundog_ocio_display(const SundogOcioConfig *config, size_t index, char **name, char **error);
bool sundog_ocio_default_display(const SundogOcioConfig *config, char **name, char **error);
bool sundog_ocio_view_count(const SundogOcioConfig *config, const char *display, size_t *count, char **error);
bool sundog_ocio_view(
    const SundogOcioConfig *config, const char *display, size_t index, SundogOcioView *view, char **error);
bool sundog_ocio_default_view(const SundogOcioConfig *config, const char *display, char **name, char **error);
void sundog_ocio_view_free(SundogOcioView *view);

bool sundog_ocio_look_count(const SundogOcioConfig *config, size_t *count, char **error);
bool sundog_ocio_look(const SundogOcioConfig *config, size_t index, SundogOcioLook *look, char **error);
void sundog_ocio_look_free(SundogOcioLook *look);

/* Whether the configuration's scene_linear space is linear Rec.709 (D65), up to the digits in which configurations write
 * their matrices. Fails where there is no way from the one to the other. */
bool sundog_ocio_is_scene_linear_rec709(const SundogOcioConfig *config, bool *is, char **error);

/* From one colour space (name, alias or role) to another. */
SundogOcioProcessor *sundog_ocio_convert_processor(
    const SundogOcioConfig *config, const char *source, const char *destination, char **error);
/* From scene light to a display's code values: exposure, look, view and display, gamma, display scale, in this order. display_size is
 * the size of the struct as the caller knows it. */
SundogOcioProcessor *sundog_ocio_display_processor(
    const SundogOcioConfig *config, const SundogOcioDisplay *display, size_t display_size, char **error);
void sundog_ocio_processor_free(SundogOcioProcessor *processor);
/* True if the processor leaves every pixel as it is. */
bool sundog_ocio_processor_is_identity(const SundogOcioProcessor *processor, bool *identity, char **error);

/* In place on `count` packed pixels of 3 or 4 floats. Alpha is handed through and does not touch the colours. */
bool sundog_ocio_apply(
    const SundogOcioProcessor *processor, float *pixels, size_t count, size_t channels, char **error);

#ifdef __cplusplus
}
#endif

#endif

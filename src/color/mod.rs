//! OpenColorIO: configs, displays, views, looks, exposure, gamma.

//! BSDF lobes and the material made of them.

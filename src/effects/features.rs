//! What a path loop is compiled with: a few coarse features, each the code for many effects.

use std::fmt::Debug;

/// Coarse features of a kernel. A kernel without a feature has neither its code nor its state; where a scene does not call
/// for the feature, both kinds of kernel give the same bits.
pub trait Features: Copy + Debug + Send + Sync + 'static {
    /// Lamps, suns and an environment, beside emissive triangles.
    const LIGHTS: bool;
    /// Normals of vertices, and meshes that are placed more than once.
    const CURVED: bool;
    /// Metals and reflections of dielectrics, over the diffuse lobe.
    const FACETS: bool;
    /// The rest: transmission, opacity, normal maps, textures, ray visibility, and the switches of studies.
    const EVERYTHING: bool;
}

/// Flat matte triangles, lit by triangles.
#[derive(Clone, Copy, Debug)]
pub struct Box;

impl Features for Box {
    const LIGHTS: bool = false;
    const CURVED: bool = false;
    const FACETS: bool = false;
    const EVERYTHING: bool = false;
}

/// Matte surfaces of any shape, under any light.
#[derive(Clone, Copy, Debug)]
pub struct Matte;

impl Features for Matte {
    const LIGHTS: bool = true;
    const CURVED: bool = true;
    const FACETS: bool = false;
    const EVERYTHING: bool = false;
}

/// Opaque surfaces that may reflect.
#[derive(Clone, Copy, Debug)]
pub struct Opaque;

impl Features for Opaque {
    const LIGHTS: bool = true;
    const CURVED: bool = true;
    const FACETS: bool = true;
    const EVERYTHING: bool = false;
}

/// Any scene.
#[derive(Clone, Copy, Debug)]
pub struct General;

impl Features for General {
    const LIGHTS: bool = true;
    const CURVED: bool = true;
    const FACETS: bool = true;
    const EVERYTHING: bool = true;
}

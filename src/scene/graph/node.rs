//! The nodes of shader graphs, by Blender's names and sockets.
//!
//! A new node is a variant of [`NodeKind`] with sockets, outputs and arithmetic here; other work is an operation in `shading::program`.

use super::super::material::{ImageUse, Texture};
use super::function::Function;
use super::shaders::{ShaderRules, SimpleBsdf, Subsurface, VolumeShader};

/// What an input takes, or an output gives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SocketKind {
    /// A number; it stands in all three places.
    Float,
    /// A colour.
    Color,
    /// Three numbers, in Blender's axes.
    Vector,
    /// Texture coordinates, in Blender's axes. Without a link they are those of the node.
    Coordinates,
    /// A normal or a tangent, outside of the surface. Without a link it is the surface's own.
    Normal,
    /// What a surface does with light. It has no value of its own.
    Shader,
}

/// An input of a node.
#[derive(Clone, Copy, Debug)]
pub struct Socket {
    /// Blender's name.
    pub name: &'static str,
    /// What it takes.
    pub kind: SocketKind,
    /// Without a link.
    pub default: [f32; 3],
    /// The legal range.
    pub legal: Legal,
}

/// Which numbers make sense.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Legal {
    /// The least number.
    pub least: f32,
    /// The greatest.
    pub most: f32,
    /// In place of what is not a number.
    pub otherwise: f32,
    /// In place of infinity: what is no number was not meant to make light.
    pub infinite: f32,
}

/// Larger numbers than this have no use and would overflow in products.
const LARGEST: f32 = 1e30;

impl Legal {
    /// Any finite number.
    pub const ANY: Self = Self::within(-LARGEST, LARGEST, 0.0);
    /// 0 to 1.
    pub const fn share(otherwise: f32) -> Self {
        Self::within(0.0, 1.0, otherwise)
    }
    /// Not below 0.
    pub const fn positive(otherwise: f32) -> Self {
        Self::within(0.0, LARGEST, otherwise)
    }
    const fn within(least: f32, most: f32, otherwise: f32) -> Self {
        Self {
            least,
            most,
            otherwise,
            infinite: most,
        }
    }
    /// Above 1 in Blender's files (SUNDOG_material): such a surface makes light. Bounded, so that a path of the default
    /// length stays within an f32.
    const ALBEDO: Self = Self {
        infinite: 1.0,
        ..Self::within(0.0, 100.0, 0.0)
    };
    /// KHR_materials_ior: 0 stands for a reflectance of 1 at all angles. Below 1 light goes from what is denser outside.
    const IOR: Self = Self::within(1e-4, LARGEST, 1.5);

    /// An index of refraction of what lies on something.
    const INDEX: Self = Self {
        infinite: 1e4,
        ..Self::within(1.0, 1e4, 1.5)
    };

    /// The nearest legal number.
    pub fn nearest(&self, value: f32) -> f32 {
        if value.is_nan() {
            self.otherwise
        } else if *self == Self::IOR && value == 0.0 {
            0.0
        } else if value == f32::INFINITY {
            self.infinite
        } else {
            value.clamp(self.least, self.most)
        }
    }
}

/// Makes a list of sockets, and a constant for the place of each in it.
macro_rules! sockets {
    ($(#[$doc:meta])* $module:ident { $($name:ident: $kind:ident $title:literal = $default:expr, $legal:expr;)* }) => {
        $(#[$doc])*
        pub mod $module {
            use super::{Legal, Socket, SocketKind};
            #[allow(non_camel_case_types, clippy::upper_case_acronyms)]
            enum Place { $($name),* }
            $(
                #[doc = concat!("\"", $title, "\".")]
                pub const $name: usize = Place::$name as usize;
            )*
            /// All of them.
            pub const SOCKETS: &[Socket] = &[$(Socket {
                name: $title,
                kind: SocketKind::$kind,
                default: $default,
                legal: $legal,
            }),*];
        }
    };
}

mod apart;

pub use apart::{
    hair, principled_hair, principled_volume, ray_portal, volume_absorption, volume_coefficients,
    volume_scatter,
};

sockets! {
    /// Inputs of the Separate Color node.
    separate { COLOR: Color "Color" = [0.8; 3], Legal::ANY; }
}
sockets! {
    /// Inputs of the Math node.
    math {
        A: Float "Value" = [0.5; 3], Legal::ANY;
        B: Float "Value" = [0.5; 3], Legal::ANY;
    }
}
sockets! {
    /// Inputs of the Mix node for colours.
    mix {
        FACTOR: Float "Factor" = [0.5; 3], Legal::share(0.5);
        A: Color "A" = [0.5; 3], Legal::ANY;
        B: Color "B" = [0.5; 3], Legal::ANY;
    }
}
sockets! {
    /// Inputs of the Normal Map node.
    normal_map {
        STRENGTH: Float "Strength" = [1.0; 3], Legal { otherwise: 1.0, ..Legal::ANY };
        COLOR: Color "Color" = [0.5, 0.5, 1.0], Legal::ANY;
    }
}
sockets! {
    /// Inputs of the Tangent node.
    tangent {
        DIRECTION: Color "Direction" = [1.0, 0.5, 0.5], Legal::ANY;
    }
}
sockets! {
    /// Inputs of the Principled BSDF.
    principled {
        BASE_COLOR: Color "Base Color" = [0.8; 3], Legal::ALBEDO;
        METALLIC: Float "Metallic" = [0.0; 3], Legal::share(0.0);
        ROUGHNESS: Float "Roughness" = [0.5; 3], Legal::share(1.0);
        IOR: Float "IOR" = [1.5; 3], Legal::IOR;
        NORMAL: Normal "Normal" = [0.0; 3], Legal::ANY;
        DIFFUSE_ROUGHNESS: Float "Diffuse Roughness" = [0.0; 3], Legal::share(0.0);
        SPECULAR_IOR_LEVEL: Float "Specular IOR Level" = [0.5; 3], Legal::positive(0.5);
        SPECULAR_TINT: Color "Specular Tint" = [1.0; 3], Legal::positive(1.0);
        ANISOTROPIC: Float "Anisotropic" = [0.0; 3], Legal::share(0.0);
        ANISOTROPIC_ROTATION: Float "Anisotropic Rotation" = [0.0; 3], Legal::ANY;
        TANGENT: Normal "Tangent" = [0.0; 3], Legal::ANY;
        TRANSMISSION_WEIGHT: Float "Transmission Weight" = [0.0; 3], Legal::share(0.0);
        EMISSION_COLOR: Color "Emission Color" = [1.0; 3], Legal::positive(0.0);
        EMISSION_STRENGTH: Float "Emission Strength" = [0.0; 3], Legal::ANY;
        COAT_WEIGHT: Float "Coat Weight" = [0.0; 3], Legal::positive(0.0);
        COAT_ROUGHNESS: Float "Coat Roughness" = [0.03; 3], Legal::share(0.03);
        COAT_IOR: Float "Coat IOR" = [1.5; 3], Legal::INDEX;
        COAT_TINT: Color "Coat Tint" = [1.0; 3], Legal::positive(1.0);
        COAT_NORMAL: Normal "Coat Normal" = [0.0; 3], Legal::ANY;
        SHEEN_WEIGHT: Float "Sheen Weight" = [0.0; 3], Legal::positive(0.0);
        SHEEN_ROUGHNESS: Float "Sheen Roughness" = [0.5; 3], Legal::share(0.5);
        SHEEN_TINT: Color "Sheen Tint" = [1.0; 3], Legal::positive(1.0);
        THIN_FILM_THICKNESS: Float "Thin Film Thickness" = [0.0; 3], Legal::positive(0.0);
        THIN_FILM_IOR: Float "Thin Film IOR" = [1.33; 3], Legal::within(1e-5, 1e4, 1.33);
        SUBSURFACE_WEIGHT: Float "Subsurface Weight" = [0.0; 3], Legal::share(0.0);
        SUBSURFACE_ANISOTROPY: Float "Subsurface Anisotropy" = [0.0; 3], Legal::within(-1.0, 1.0, 0.0);
        SUBSURFACE_COLOR: Color "Color Below the Surface" = [0.8; 3], Legal::ALBEDO;
        SUBSURFACE_RADIUS: Vector "Subsurface Radius" = [1.0, 0.2, 0.1], Legal::positive(1.0);
        SUBSURFACE_SCALE: Float "Subsurface Scale" = [0.05; 3], Legal::positive(0.0);
        SUBSURFACE_IOR: Float "Subsurface IOR" = [1.4; 3], Legal::within(1.01, 3.8, 1.4);
        DISPERSION: Float "Dispersion" = [0.0; 3], Legal::within(0.0, 1e4, 0.0);
    }
}
sockets! {
    /// Inputs of the Diffuse BSDF.
    diffuse {
        COLOR: Color "Color" = [0.8; 3], Legal::ALBEDO;
        ROUGHNESS: Float "Roughness" = [0.0; 3], Legal::share(0.0);
        NORMAL: Normal "Normal" = [0.0; 3], Legal::ANY;
    }
}
sockets! {
    /// Inputs of the Glossy BSDF.
    glossy {
        COLOR: Color "Color" = [0.8; 3], Legal::ALBEDO;
        ROUGHNESS: Float "Roughness" = [0.5; 3], Legal::share(1.0);
        ANISOTROPY: Float "Anisotropy" = [0.0; 3], Legal::within(-1.0, 1.0, 0.0);
        ROTATION: Float "Rotation" = [0.0; 3], Legal::ANY;
        NORMAL: Normal "Normal" = [0.0; 3], Legal::ANY;
        TANGENT: Normal "Tangent" = [0.0; 3], Legal::ANY;
    }
}
sockets! {
    /// Inputs of the Translucent BSDF.
    translucent {
        COLOR: Color "Color" = [0.8; 3], Legal::ALBEDO;
        NORMAL: Normal "Normal" = [0.0; 3], Legal::ANY;
    }
}
sockets! {
    /// Inputs of the Refraction BSDF and of the Glass BSDF.
    glass {
        COLOR: Color "Color" = [1.0; 3], Legal::ALBEDO;
        ROUGHNESS: Float "Roughness" = [0.0; 3], Legal { otherwise: 1.0, ..Legal::ANY };
        IOR: Float "IOR" = [1.5; 3], Legal::within(1e-4, 1e4, 1.5);
        THIN_FILM_THICKNESS: Float "Thin Film Thickness" = [0.0; 3], Legal::positive(0.0);
        THIN_FILM_IOR: Float "Thin Film IOR" = [1.33; 3], Legal::within(1e-5, 1e4, 1.33);
        NORMAL: Normal "Normal" = [0.0; 3], Legal::ANY;
        ANISOTROPY: Float "Anisotropy" = [0.0; 3], Legal::within(-1.0, 1.0, 0.0);
        ROTATION: Float "Rotation" = [0.0; 3], Legal::ANY;
        TANGENT: Normal "Tangent" = [0.0; 3], Legal::ANY;
    }
}
sockets! {
    /// Inputs of the Metallic BSDF.
    metallic {
        BASE_COLOR: Color "Base Color" = [0.617, 0.577, 0.54], Legal::share(0.0);
        EDGE_TINT: Color "Edge Tint" = [0.695, 0.726, 0.77], Legal::share(1.0);
        IOR: Color "IOR" = [2.757, 2.513, 2.231], Legal::positive(1.0);
        EXTINCTION: Color "Extinction" = [3.867, 3.404, 3.009], Legal::positive(0.0);
        THIN_FILM_THICKNESS: Float "Thin Film Thickness" = [0.0; 3], Legal::positive(0.0);
        THIN_FILM_IOR: Float "Thin Film IOR" = [1.33; 3], Legal::within(1e-5, 1e4, 1.33);
        ROUGHNESS: Float "Roughness" = [0.5; 3], Legal::share(1.0);
        ANISOTROPY: Float "Anisotropy" = [0.0; 3], Legal::share(0.0);
        ROTATION: Float "Rotation" = [0.0; 3], Legal::ANY;
        NORMAL: Normal "Normal" = [0.0; 3], Legal::ANY;
        TANGENT: Normal "Tangent" = [0.0; 3], Legal::ANY;
    }
}
sockets! {
    /// Inputs of the Sheen BSDF.
    sheen {
        COLOR: Color "Color" = [0.8; 3], Legal::ALBEDO;
        ROUGHNESS: Float "Roughness" = [0.5; 3], Legal::share(0.5);
        NORMAL: Normal "Normal" = [0.0; 3], Legal::ANY;
    }
}
sockets! {
    /// Inputs of the Toon BSDF.
    toon {
        COLOR: Color "Color" = [0.8; 3], Legal::ALBEDO;
        SIZE: Float "Size" = [0.5; 3], Legal::share(0.5);
        SMOOTH: Float "Smooth" = [0.0; 3], Legal::share(0.0);
        NORMAL: Normal "Normal" = [0.0; 3], Legal::ANY;
    }
}
sockets! {
    /// Inputs of the Subsurface Scattering node.
    subsurface {
        COLOR: Color "Color" = [0.8; 3], Legal::ALBEDO;
        SCALE: Float "Scale" = [0.05; 3], Legal::positive(0.0);
        RADIUS: Vector "Radius" = [1.0, 0.2, 0.1], Legal::positive(1.0);
        IOR: Float "IOR" = [1.4; 3], Legal::within(1.01, 3.8, 1.4);
        ROUGHNESS: Float "Roughness" = [1.0; 3], Legal::share(1.0);
        ANISOTROPY: Float "Anisotropy" = [0.0; 3], Legal::within(-1.0, 1.0, 0.0);
        NORMAL: Normal "Normal" = [0.0; 3], Legal::ANY;
    }
}
sockets! {
    /// Inputs of the Transparent BSDF.
    transparent { COLOR: Color "Color" = [1.0; 3], Legal { otherwise: 1.0, ..Legal::ALBEDO }; }
}
sockets! {
    /// Inputs of the Emission shader.
    emission {
        COLOR: Color "Color" = [1.0; 3], Legal::positive(0.0);
        STRENGTH: Float "Strength" = [1.0; 3], Legal::ANY;
    }
}
sockets! {
    /// Inputs of the Mix Shader.
    mix_shader {
        FACTOR: Float "Fac" = [0.5; 3], Legal::share(1.0);
        A: Shader "Shader" = [0.0; 3], Legal::ANY;
        B: Shader "Shader" = [0.0; 3], Legal::ANY;
    }
}
sockets! {
    /// Inputs of the Add Shader.
    add_shader {
        A: Shader "Shader" = [0.0; 3], Legal::ANY;
        B: Shader "Shader" = [0.0; 3], Legal::ANY;
    }
}

/// Weights of a Principled BSDF's layers, with the sockets that count only where the layer is.
pub const LAYERS: [(usize, &[usize]); 3] = [
    (
        principled::COAT_WEIGHT,
        &[
            principled::COAT_ROUGHNESS,
            principled::COAT_IOR,
            principled::COAT_TINT,
            principled::COAT_NORMAL,
        ],
    ),
    (
        principled::SHEEN_WEIGHT,
        &[principled::SHEEN_ROUGHNESS, principled::SHEEN_TINT],
    ),
    (
        principled::SUBSURFACE_WEIGHT,
        &[
            principled::SUBSURFACE_ANISOTROPY,
            principled::SUBSURFACE_COLOR,
            principled::SUBSURFACE_RADIUS,
            principled::SUBSURFACE_SCALE,
            principled::SUBSURFACE_IOR,
        ],
    ),
];

/// Operations of the Math node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MathOperation {
    /// a + b.
    Add,
    /// a − b.
    Subtract,
    /// a · b.
    Multiply,
    /// a / b, and 0 where b is 0.
    Divide,
    /// a to the power of b, and 0 where that is no real number.
    Power,
    /// The lesser.
    Minimum,
    /// The greater.
    Maximum,
    /// 1 where a < b, otherwise 0.
    LessThan,
    /// 1 where a > b, otherwise 0.
    GreaterThan,
}

impl MathOperation {
    /// The result, as Blender defines it.
    #[inline]
    pub fn of(self, a: f32, b: f32) -> f32 {
        match self {
            Self::Add => a + b,
            Self::Subtract => a - b,
            Self::Multiply => a * b,
            Self::Divide if b == 0.0 => 0.0,
            Self::Divide => a / b,
            Self::Power if a < 0.0 && b != b.trunc() => 0.0,
            Self::Power => a.powf(b),
            Self::Minimum => a.min(b),
            Self::Maximum => a.max(b),
            Self::LessThan => f32::from(a < b),
            Self::GreaterThan => f32::from(a > b),
        }
    }
}

/// How the Mix node for colours blends B over A.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Blend {
    /// B instead of A.
    Mix,
    /// A · B.
    Multiply,
    /// A + B.
    Add,
}

impl Blend {
    /// The result; with a factor of 1 all of it is B's, bit for bit.
    #[inline]
    pub fn of(self, factor: f32, a: glam::Vec3, b: glam::Vec3) -> glam::Vec3 {
        let all = match self {
            Self::Mix => b,
            Self::Multiply => a * b,
            Self::Add => a + b,
        };
        if factor == 1.0 {
            all
        } else {
            a * (1.0 - factor) + all * factor
        }
    }
}

/// What a tangent follows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TangentKind {
    /// Texture coordinates: the direction of growing u, or one turned from it.
    Uv,
    /// Circles about the mesh's own Z axis, by its generated coordinates.
    Radial,
}

/// The spread of the Glossy BSDF's facets.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Distribution {
    /// GGX.
    #[default]
    Ggx,
    /// GGX with the energy of multiple scattering.
    MultiscatterGgx,
    /// Beckmann's.
    Beckmann,
    /// The Phong distribution of Ashikhmin and Shirley, which only the Glossy BSDF has.
    AshikhminShirley,
}

sockets! {
    /// Inputs of the Image Texture node.
    image_texture { VECTOR: Coordinates "Vector" = [0.0; 3], Legal::ANY; }
}

/// Axes of a normal map's texels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum NormalSpace {
    /// Tangent, bitangent, normal. The strength scales the first two before normalisation, as in glTF.
    #[default]
    Gltf,
    /// Tangent, bitangent, normal. The strength goes from the surface's own normal to the map's, as in Blender.
    Tangent,
    /// The same, but the normal is as it comes between those of the corners, shorter where these spread, as in Cycles before 5.1.
    Spread,
    /// As `Tangent`, of the surface before it was displaced, by the attribute of vertices that keeps its normals.
    Before(u32),
    /// The object's, in Blender's axes.
    Object,
    /// The world's, in Blender's axes.
    World,
}

/// How an image lies in the space of its coordinates.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub enum ImageProjection {
    /// By the first two.
    #[default]
    Flat,
    /// On the sides of a box, blended over so much of the edges.
    Box {
        /// 0 to 1.
        blend: f32,
    },
    /// About the Z axis, on a sphere.
    Sphere,
    /// About the Z axis, on a tube.
    Tube,
    /// By direction, as the Environment Texture has it.
    Equirectangular,
    /// By direction, as a mirrored ball shows all around it.
    MirrorBall,
}

/// What a node is, with its properties that are no sockets.
#[derive(Clone, Debug, PartialEq)]
pub enum NodeKind {
    /// An image: Color, Alpha.
    ImageTexture {
        /// Which, and how it lies on the surface.
        texture: Texture,
        /// What its values mean.
        usage: ImageUse,
        /// How it lies in the space of linked coordinates.
        projection: ImageProjection,
    },
    /// Images on unit squares of the plane of coordinates (UDIM); pink where there is none: Color, Alpha.
    TiledImage {
        /// The squares' numbers: 1001 at the origin, one more along u, ten more along v.
        numbers: Vec<u32>,
        /// An image for each.
        textures: Vec<Texture>,
        /// What their values mean.
        usage: ImageUse,
        /// How they lie in the space of coordinates.
        projection: ImageProjection,
    },
    /// What other nodes compute.
    Function(Function),
    /// Colours of vertices, white where there are none: Color, Alpha.
    ColorAttribute,
    /// A colour's numbers: Red, Green, Blue.
    SeparateColor,
    /// Arithmetic.
    Math {
        /// Which.
        operation: MathOperation,
        /// The result is brought to 0..=1.
        clamp: bool,
    },
    /// The Mix node for colours.
    MixColor {
        /// How.
        blend: Blend,
    },
    /// A normal map.
    NormalMap {
        /// In which axes its texels are, and what its strength does.
        space: NormalSpace,
    },
    /// A direction along the surface. That of texture coordinates may be turned by a direction in tangent space, whose x and y
    /// stand as numbers 0 to 1 for -1 to 1.
    Tangent {
        /// What it follows.
        kind: TangentKind,
    },
    /// Blender's Principled BSDF.
    PrincipledBsdf {
        /// Transmission without refraction, as through a thin sheet; otherwise the surface bounds a solid.
        thin_wall: bool,
        /// Such a sheet is Blender's, with reflections between its sides, and light goes through below its surface.
        pane: bool,
        /// The Specular Tint tints the edges of metals too, as in Blender; glTF has no word for that.
        edge_tint: bool,
        /// Its facets scatter once, in the place of all the times that light stays between them.
        once: bool,
        /// How light goes on below its surface, where it does not come out on both sides as from a sheet.
        walk: Option<Subsurface>,
        /// Whose version it follows.
        rules: ShaderRules,
    },
    /// Diffuse reflection.
    DiffuseBsdf {
        /// Whose version it follows where it is rough.
        rules: ShaderRules,
    },
    /// Reflection by facets.
    GlossyBsdf {
        /// Their spread.
        distribution: Distribution,
    },
    /// Another shader of one lobe.
    Bsdf(SimpleBsdf),
    /// Light passes straight on.
    TransparentBsdf,
    /// The picture is empty where the camera sees it, beside other shaders. A surface that is nothing else is an instance's.
    Holdout,
    /// Emitted light.
    Emission,
    /// A of one factor, B of the rest.
    MixShader,
    /// The sum.
    AddShader,
    /// What fills a mesh or all space.
    Volume(VolumeShader),
}

/// Which of four numbers an output is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lane {
    /// The first three: a colour, of which a number is the luminance.
    Rgb,
    /// The first three: a vector, of which a number is the mean.
    Xyz,
    /// The mean of the first three: a number, for vectors too.
    Mean,
    /// One of them: 0 to 3.
    One(u8),
}

/// Outputs of nodes with one.
pub const ONLY: u8 = 0;
/// Output "Color" of images and attributes.
pub const COLOR: u8 = 0;
/// Output "Alpha" of images and attributes.
pub const ALPHA: u8 = 1;
/// Output "Vector" of attributes.
pub const VECTOR: u8 = 2;
/// Output "Fac" of attributes.
pub const FACTOR: u8 = 3;
/// Outputs of Separate Color.
pub const RED: u8 = 0;
/// Outputs of Separate Color.
pub const GREEN: u8 = 1;
/// Outputs of Separate Color.
pub const BLUE: u8 = 2;

impl NodeKind {
    /// Whether it sends rays elsewhere.
    pub fn is_portal(&self) -> bool {
        matches!(self, Self::Bsdf(SimpleBsdf::RayPortal { .. }))
    }

    /// The inputs, in their order.
    pub fn sockets(&self) -> &'static [Socket] {
        match self {
            Self::ImageTexture { .. } | Self::TiledImage { .. } => image_texture::SOCKETS,
            Self::Function(function) => function.sockets(),
            Self::ColorAttribute => &[],
            Self::SeparateColor => separate::SOCKETS,
            Self::Math { .. } => math::SOCKETS,
            Self::MixColor { .. } => mix::SOCKETS,
            Self::NormalMap { .. } => normal_map::SOCKETS,
            Self::Tangent { .. } => tangent::SOCKETS,
            Self::PrincipledBsdf { .. } => principled::SOCKETS,
            Self::DiffuseBsdf { .. } => diffuse::SOCKETS,
            Self::GlossyBsdf { .. } => glossy::SOCKETS,
            Self::Bsdf(bsdf) => bsdf.sockets(),
            Self::TransparentBsdf => transparent::SOCKETS,
            Self::Holdout => &[],
            Self::Emission => emission::SOCKETS,
            Self::MixShader => mix_shader::SOCKETS,
            Self::AddShader => add_shader::SOCKETS,
            Self::Volume(shader) => shader.sockets(),
        }
    }

    /// The outputs: what they give, and which numbers of the node's result they are.
    pub fn outputs(&self) -> &'static [(SocketKind, Lane)] {
        use SocketKind::{Color, Float, Normal, Shader};
        match self {
            Self::Function(function) => function.outputs(),
            Self::ImageTexture { .. } | Self::TiledImage { .. } | Self::ColorAttribute => {
                &[(Color, Lane::Rgb), (Float, Lane::One(3))]
            }
            Self::SeparateColor => &[
                (Float, Lane::One(0)),
                (Float, Lane::One(1)),
                (Float, Lane::One(2)),
            ],
            Self::Math { .. } => &[(Float, Lane::One(0))],
            Self::MixColor { .. } => &[(Color, Lane::Rgb)],
            Self::NormalMap { .. } | Self::Tangent { .. } => &[(Normal, Lane::Rgb)],
            Self::PrincipledBsdf { .. }
            | Self::DiffuseBsdf { .. }
            | Self::GlossyBsdf { .. }
            | Self::Bsdf(_)
            | Self::TransparentBsdf
            | Self::Holdout
            | Self::Emission
            | Self::MixShader
            | Self::AddShader
            | Self::Volume(_) => &[(Shader, Lane::Rgb)],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_brought_to_the_nearest_legal_one() {
        let base = principled::SOCKETS[principled::BASE_COLOR].legal;
        assert_eq!(
            [f32::NAN, f32::INFINITY, -1.0, 2.0, 1e38].map(|v| base.nearest(v)),
            [0.0, 1.0, 0.0, 2.0, 100.0]
        );
        let ior = principled::SOCKETS[principled::IOR].legal;
        let nearest = [0.0, 1e-6, 0.5, 2.0].map(|v| ior.nearest(v));
        assert_eq!(nearest, [0.0, 1e-4, 0.5, 2.0]);
    }

    #[test]
    fn arithmetic_is_blenders() {
        use MathOperation::{Divide, LessThan, Power, Subtract};
        assert_eq!(Divide.of(1.0, 0.0), 0.0);
        assert_eq!(Power.of(-2.0, 0.5), 0.0);
        assert_eq!(Power.of(-2.0, 2.0), 4.0);
        assert_eq!(Subtract.of(1.0, 3.0), -2.0);
        assert_eq!((LessThan.of(0.5, 0.5), LessThan.of(0.4, 0.5)), (0.0, 1.0));
        let (a, b) = (glam::Vec3::splat(0.25), glam::Vec3::splat(0.5));
        assert_eq!(Blend::Multiply.of(1.0, a, b), a * b);
        assert_eq!(Blend::Mix.of(0.5, a, b).x, 0.375);
    }
}

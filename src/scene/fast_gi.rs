//! Blender's fast approximation of indirect light.

/// What stands for light that comes by many bounces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FastGi {
    /// How.
    pub method: FastGiMethod,
    /// What the light that it brings is multiplied with.
    pub factor: f32,
    /// How far surfaces are that hide it, metres.
    pub distance: f32,
}

/// How something stands for it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FastGiMethod {
    /// After so many bounces the world shines past all that is not near, and paths end.
    Replace {
        /// As Cycles counts them: at least 1.
        bounces: u32,
    },
    /// Light from all around is added at each surface, by what of it is open.
    Add,
}

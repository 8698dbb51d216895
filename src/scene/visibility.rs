//! Which rays see an object, a light or the world.

/// What Cycles tells rays apart by: a ray is of the kind of the scattering that it leaves from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RayKind {
    /// From the camera.
    Camera,
    /// From a diffuse reflection.
    Diffuse,
    /// From a glossy reflection.
    Glossy,
    /// From a transmission.
    Transmission,
    /// From a volume.
    Volume,
    /// From a lit point to a light.
    Shadow,
}

impl RayKind {
    /// All of them, with their names in `SUNDOG_` extensions.
    pub const ALL: [(Self, &str); 6] = [
        (Self::Camera, "camera"),
        (Self::Diffuse, "diffuse"),
        (Self::Glossy, "glossy"),
        (Self::Transmission, "transmission"),
        (Self::Volume, "volume"),
        (Self::Shadow, "shadow"),
    ];

    /// Its bit in a [`Visibility`], and in Embree's masks.
    #[inline]
    pub const fn bit(self) -> u32 {
        1 << self as u32
    }
}

/// A set of kinds of rays.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Visibility(u32);

impl Visibility {
    /// Seen by all rays.
    pub const ALL: Self = Self((1 << RayKind::ALL.len()) - 1);

    /// The same without one kind.
    #[must_use]
    pub const fn without(self, kind: RayKind) -> Self {
        Self(self.0 & !kind.bit())
    }

    /// The same with one kind.
    #[must_use]
    pub const fn with(self, kind: RayKind) -> Self {
        Self(self.0 | kind.bit())
    }

    /// The same, but seen by all rays that surfaces scatter.
    #[must_use]
    pub const fn on_paths(self) -> Self {
        self.with(RayKind::Diffuse)
            .with(RayKind::Glossy)
            .with(RayKind::Transmission)
    }

    /// Whether shadow rays and all rays that surfaces scatter see it, or none of them.
    pub fn is_alike_on_paths(self) -> bool {
        let paths = Self(0).on_paths().with(RayKind::Shadow).0;
        self.0 & paths == paths || self.0 & paths == 0
    }

    /// What is left where another stands in the same place: the rays that do not see the other. Shadow rays stay as they
    /// are, as they say how the light of it falls.
    #[must_use]
    pub const fn behind(self, other: Self) -> Self {
        let shadow = RayKind::Shadow.bit();
        Self(self.0 & (!other.0 | shadow))
    }

    /// Whether no path sees it, nor the camera.
    pub const fn is_nothing(self) -> bool {
        self.0 & !RayKind::Shadow.bit() == 0
    }

    /// Whether rays of a kind see it.
    #[inline]
    pub const fn sees(self, kind: RayKind) -> bool {
        self.0 & kind.bit() != 0
    }

    /// As bits ([`RayKind::bit`]).
    #[inline]
    pub const fn bits(self) -> u32 {
        self.0
    }

    /// Names of the kinds that do not see it.
    pub fn hidden_from(self) -> Vec<&'static str> {
        RayKind::ALL
            .iter()
            .filter(|(kind, _)| !self.sees(*kind))
            .map(|(_, name)| *name)
            .collect()
    }
}

impl Default for Visibility {
    fn default() -> Self {
        Self::ALL
    }
}

#[cfg(test)]
#[path = "../../tests/unit/scene/visibility.rs"]
mod tests;

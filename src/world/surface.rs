//! The surface at a hit: where it is, which way it faces, what it emits and what its material says.

use super::asking::{Around, Asking};
use super::geometry::{MeshData, MeshInstance, unit_or_zero};
use super::material::PreparedMaterial;
use super::place::HitPoint;
use super::strand::OnStrand;
use crate::effects::Features;
use crate::ffi::embree::Hit;
use crate::math::float::{self, BoundedPoint, is_unit};
use crate::shading::Normals;
use crate::shading::program::Computed;
use crate::shading::{Bsdf, BsdfFeatures, Dielectrics, Principled};
use glam::Vec3;

/// What is asked of a surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wanted {
    /// Where it is and what it emits: its shading normal is the smooth one.
    Light,
    /// Its lobes too.
    Lobes,
}

/// All that shading needs to know about a hit.
pub struct Surface<'a> {
    /// Where, with its error bound.
    pub point: BoundedPoint,
    /// On the side from which the ray came.
    pub normals: Normals,
    /// The ray came from behind (by winding).
    pub inside: bool,
    /// Emitted radiance towards the ray's origin.
    pub emission: Vec3,
    /// It only emits.
    unlit: bool,
    /// What the material says where it is the same everywhere …
    constant: &'a Principled,
    /// … and where it is not, at this point.
    varying: Option<Principled>,
    /// Tables of its dielectric.
    pub dielectrics: &'a Dielectrics,
    /// In place of the parameters: what has other shaders than one Principled BSDF.
    pub mixed: Option<Mixed<'a>>,
    /// Its index of refraction depends on the wavelength.
    pub disperses: bool,
    /// It is of a strand or a point: rays leave it in all directions, and do not meet that again.
    pub is_strand: bool,
}

impl Surface<'_> {
    /// Whether it only emits.
    #[inline]
    pub fn is_unlit(&self) -> bool {
        self.unlit
    }

    /// What the material says, where it is not [`Self::mixed`].
    #[inline]
    pub fn principled(&self) -> &Principled {
        self.varying.as_ref().unwrap_or(self.constant)
    }
}

/// A surface of several shaders, or of another than a Principled BSDF.
pub struct Mixed<'a> {
    material: &'a PreparedMaterial,
    place: HitPoint<'a>,
    inside: bool,
    computed: &'a mut Computed,
}

impl Mixed<'_> {
    /// Whether what goes on below the surface has a normal of its own.
    pub fn bumps_below(&self) -> bool {
        self.material.bumps_below()
    }

    /// Adds the lobes of the shaders whose weight is not zero. `smooth`: the normal of shaders without a normal map.
    #[cold]
    #[inline(never)]
    pub fn add_to<K: BsdfFeatures>(&mut self, bsdf: &mut Bsdf<K>, smooth: Vec3) {
        let inside = self.inside;
        let side = |n: Vec3| match n {
            Vec3::ZERO => smooth,
            n if inside => -n,
            n => n,
        };
        let place = (&self.place, self.place.asking.past, &mut *self.computed);
        self.material.add_shaders(place, side, bsdf);
    }
}

#[inline]
pub fn surface<'a, E: Features>(
    (entry, mesh, triangle): (&'a MeshInstance, &'a MeshData, u32),
    material: &'a PreparedMaterial,
    hit: &Hit,
    (origin, asking): (Vec3, Asking<'a>),
    wanted: Wanted,
    around: Option<&'a dyn Around>,
    computed: &'a mut Option<Computed>,
) -> Surface<'a> {
    let direction = asking.direction;
    // Looked up once.
    let mut at = entry.at(mesh, (triangle, hit.u, hit.v), asking);
    if E::EVERYTHING {
        at.around = around;
    }
    let along = direction * hit.distance;
    let strand = if E::EVERYTHING {
        OnStrand::of(&at)
    } else {
        None
    };
    let (point, outside, mut smooth_outside) = match strand {
        // Light is scattered about the normal of what is round, as in Cycles.
        Some(strand) => (strand.met(origin, along), strand.normal, strand.normal),
        None => {
            let corners = mesh.triangles.between(at.corners).map(Vec3::from);
            let by_corners = entry.point_between::<E>(corners, hit.u, hit.v);
            let point = float::hit_point(by_corners, origin, along);
            let outside = entry.normal_between::<E>(corners);
            let mut smooth = outside;
            if E::CURVED
                && let Some(normals) = &mesh.normals
            {
                let n = unit_or_zero(entry.normal::<E>(at.vector(normals)));
                if n != Vec3::ZERO {
                    smooth = n;
                }
            }
            (point, outside, smooth)
        }
    };
    at.outside = strand.map_or(outside, |strand| strand.facing);
    let inside = outside.dot(direction) > 0.0;
    let side = |n: Vec3| if inside { -n } else { n };
    let geometric = side(outside);

    let mut smooth = side(smooth_outside);
    let curved = smooth;
    if E::EVERYTHING && material.has_normal() {
        let n = material.normal(&HitPoint {
            normal: smooth_outside,
            ..at
        });
        if n != Vec3::ZERO {
            (smooth, smooth_outside, at.normal) = (side(n), n, n);
        }
    }
    let with_lobes = E::EVERYTHING && wanted == Wanted::Lobes;
    if with_lobes {
        at.normal = smooth_outside;
    }
    let shared = with_lobes.then(|| material.emitted_with_lobes(&at, computed));
    let emission = shared.flatten().unwrap_or_else(|| material.emitted(&at));
    let mut shading = smooth;
    let mut mixed = None;
    let mut varying = None;
    if with_lobes {
        if let Some((parameters, normal)) = material.parameters(&at, computed) {
            varying = Some(parameters);
            if normal != Vec3::ZERO {
                shading = side(normal);
            }
        }
        let past = asking.past;
        if material.disperses() || past.other_side > 0.0 {
            let p = varying.unwrap_or(*material.constant_parameters());
            varying = Some(p.seen_in(past.wavelength).beside(past.other_side));
        }
        mixed = material.is_mixed().then_some(Mixed {
            material,
            place: at,
            inside,
            computed: computed.get_or_insert_default(),
        });
    }
    debug_assert!(
        [geometric, smooth, shading]
            .into_iter()
            .all(|n| n == Vec3::ZERO || is_unit(n)),
        "normals {geometric} {smooth} {shading}"
    );
    let other_side = if E::EVERYTHING {
        asking.past.other_side
    } else {
        0.0
    };
    let tables = material.tables_beside(other_side);
    Surface {
        point,
        normals: Normals {
            geometric,
            curved,
            smooth,
            shading,
        },
        inside,
        emission,
        unlit: material.unlit,
        constant: material.constant_parameters(),
        varying,
        dielectrics: &tables.dielectrics,
        mixed,
        disperses: E::EVERYTHING && material.disperses(),
        is_strand: strand.is_some(),
    }
}

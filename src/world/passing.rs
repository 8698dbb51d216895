//! What rays meet and what they pass: opacity, tinted transparency, the share of light that a shadow ray brings.

use super::*;
use crate::light::program::{LookingRay, ShinePoint};
use crate::math::average;
use crate::sampler::{Dimension, Sampler};
use crate::scene::graph::function::{PathDepth, PlaceInput};
use crate::shading::program::Programs;

/// A ray that looks for what takes the light.
#[inline]
pub(super) fn shadow_ray((origin, direction): (Vec3, Vec3), far: f32, time: f32) -> Ray {
    Ray {
        origin: origin.to_array(),
        direction: direction.to_array(),
        near: float::RAY_START,
        far,
        mask: RayKind::Shadow.bit(),
        time,
    }
}

/// A ray on a path.
#[inline]
fn sent((origin, direction): (Vec3, Vec3), (near, far): (f32, f32), sender: &Sender) -> Ray {
    Ray {
        origin: origin.to_array(),
        direction: direction.to_array(),
        near,
        far,
        mask: sender.kind.bit(),
        time: sender.time,
    }
}

/// Whether the opacity hangs on what a path has passed before, or on what is around: paths stop there.
pub(super) fn asks_paths(programs: &Programs) -> bool {
    programs.opacity.as_ref().is_some_and(|opacity| {
        let counted = PlaceInput::PathDepth(PathDepth::Transparent);
        opacity.program.traces() || opacity.program.place_inputs().contains(&counted)
    })
}

/// Whether something else than images and sections of fibres tells the opacity: these are mostly 0 or 1. Paths stop there, and choose
/// between what passes and what each lobe takes by one number, whose samples are spread evenly.
pub(super) fn is_blended(programs: &Programs) -> bool {
    let is_cover = |input: &PlaceInput| matches!(input, PlaceInput::FibreCover(_));
    programs.opacity.as_ref().is_some_and(|opacity| {
        let program = &opacity.program;
        program.textures().is_empty() && !program.place_inputs().iter().any(is_cover)
    })
}

/// The number of a path's bounce about what a ray meets.
#[inline(never)]
fn number(hit: &Hit, (sampler, bounce): (&Sampler, u32)) -> f32 {
    sampler.about(Dimension::Opacity, bounce, parts(hit))
}

/// What tells a hit's surface from others.
pub(super) fn parts(hit: &Hit) -> (u32, u32) {
    let object = hit.geometry ^ hit.instance.unwrap_or(0).rotate_left(16);
    (hit.primitive, object)
}

/// What is left of a shadow ray's light.
pub(super) struct Share {
    pub light: Vec3,
    /// Surfaces that it may still pass, if that is limited.
    left: Option<u32>,
}

impl Share {
    /// All of it. `limit`: `u32::MAX` is none.
    #[inline]
    pub fn within(limit: u32) -> Self {
        Self {
            light: Vec3::ONE,
            left: (limit != u32::MAX).then_some(limit),
        }
    }
}

/// A portal of less weight is none, as in Cycles.
const LEAST_PORTAL: f32 = 1e-5;

impl PreparedMaterial {
    /// What passes straight on at a point, as a colour, and the share of the rest.
    pub fn passing(&self, at: &impl Place) -> (Vec3, f32) {
        match &self.programs.opacity {
            None => (Vec3::ZERO, 1.0),
            Some(opacity) => opacity.program.at(at, |at| {
                (at.color(&opacity.transmittance), at.number(&opacity.rest))
            }),
        }
    }

    /// What portals take at a point beside what passes straight on, as a colour; `None` where that is nothing.
    pub fn portal(&self, at: &impl Place) -> Option<Vec3> {
        let opacity = self.programs.opacity.as_ref()?;
        let root = opacity.portal.as_ref()?;
        let taken = opacity.program.at(at, |at| at.color(root));
        (average(taken) >= LEAST_PORTAL).then_some(taken)
    }

    /// The share of a point that holdouts empty; `None` where no shader is one.
    pub fn held_out(&self, at: &impl Place) -> Option<f32> {
        let opacity = self.programs.opacity.as_ref()?;
        let root = opacity.holdout.as_ref()?;
        Some(opacity.program.at(at, |at| at.number(root)))
    }

    /// [`Self::passing`] for shadow rays. They pass no portal, nor beside it, so that rays find what is behind it. Cycles' count a
    /// portal to what is transparent beside it, if something is, although rays find that light again.
    pub fn passing_to_light(&self, at: &impl Place, as_cycles: bool) -> (Vec3, f32) {
        let (passes, rest) = self.passing(at);
        match self.portal(at) {
            None => (passes, rest),
            Some(portal) if as_cycles && average(passes) >= LEAST_PORTAL => (passes + portal, rest),
            Some(_) => (Vec3::ZERO, 1.0),
        }
    }

    /// Opacity at a point, 0..=1; cut-outs are 0 or 1.
    #[inline]
    pub fn opacity(&self, at: &impl Place) -> f32 {
        match &self.programs.opacity {
            None => 1.0,
            Some(opacity) => opacity.program.at(at, |at| at.number(&opacity.rest)),
        }
    }

    /// Whether a holdout is among its shaders.
    #[inline]
    pub fn has_holdout(&self) -> bool {
        has_holdout(&self.programs)
    }
}

/// Whether the picture is empty where the camera sees some of it.
pub(super) fn has_holdout(programs: &Programs) -> bool {
    let opacity = programs.opacity.as_ref();
    opacity.is_some_and(|opacity| opacity.holdout.is_some())
}

impl World {
    /// Whether a hit is on a back face that is not there.
    #[inline]
    fn is_hidden(&self, hit: &Hit, direction: Vec3) -> bool {
        if !self.cull_backfaces {
            return false;
        }
        let mut moment = None;
        let (entry, mesh, triangle) = self.object_at::<General>(hit, &mut moment);
        self.materials[mesh.material as usize].single_sided
            && entry
                .geometric_normal::<General>(mesh, triangle)
                .dot(direction)
                > 0.0
    }

    /// Opacity of a hit (0 for a back face that is hidden).
    #[inline]
    pub(super) fn opacity<E: Features>(&self, hit: &Hit, direction: Vec3, sender: &Sender) -> f32 {
        if self.is_hidden(hit, direction) || E::EVERYTHING && self.is_left(hit, sender.past.left) {
            return 0.0;
        }
        let material = self.prepared(hit);
        if !E::EVERYTHING || !material.translucent {
            return 1.0;
        }
        // Paths stop there, and decide for themselves what passes.
        if material.is_tinted {
            return 1.0;
        }
        let asking = Asking::of(sender, direction, hit);
        let mut moment = None;
        let (entry, mesh, triangle) = self.object_at::<E>(hit, &mut moment);
        let at = entry.at(mesh, (triangle, hit.u, hit.v), asking);
        material.opacity(&at)
    }

    /// Whether the shadow ray of a light sample meets the surface that it leaves, as in Cycles: where a displacement that is a bump has
    /// turned the normal of a smooth mesh away from a light before it, the ray's start is sought on the other side
    /// (`shadow_ray_offset`; with a Shadow Terminator Geometry Offset above 0, which is the default).
    #[inline]
    pub fn meets_own_surface(&self, hit: &Hit, surface: &Surface, wi: Vec3) -> bool {
        let normals = &surface.normals;
        if !self.as_cycles || normals.smooth == normals.curved {
            return false;
        }
        let turned = wi.dot(normals.smooth) < 0.0 && wi.dot(normals.geometric) > 0.0;
        turned && {
            let entry = &self.geometry.entries[hit.object() as usize];
            let mesh = &self.geometry.meshes[entry.mesh as usize];
            mesh.is_shaded_smooth && mesh.strands.is_none()
        }
    }

    /// Whether what passes straight on takes a colour somewhere.
    #[inline]
    pub fn is_tinted(&self) -> bool {
        self.geometry.tinted
    }

    /// Whether programs ask the scene by rays.
    #[inline]
    pub fn traces(&self) -> bool {
        self.geometry.traces
    }

    /// Radians of a pixel, where Bumps are widened by what has scattered a path.
    #[inline]
    pub fn widened(&self) -> Option<f32> {
        self.geometry.widened
    }

    /// What a ray meets first, also if the path passes it.
    pub fn first(&self, ray: (Vec3, Vec3, (f32, f32)), sender: &Sender) -> Option<Hit> {
        let (origin, direction, (near, far)) = ray;
        self.geometry
            .embree
            .intersect(&sent((origin, direction), (near, far), sender))
    }

    /// Adds what a hit tells passes of the scene's own. What passes straight on there, as a colour, and the share of the rest.
    pub fn add_aovs(&self, hit: &Hit, asking: Asking, sums: &mut [f64]) -> (Vec3, f32) {
        let mut moment = None;
        let (entry, mesh, triangle) = self.object_at::<General>(hit, &mut moment);
        let material = &self.materials[mesh.material as usize];
        let mut at = entry.at(mesh, (triangle, hit.u, hit.v), asking);
        at.around = self.traces().then_some(self);
        if material.has_normal() {
            at.normal = material.normal(&at);
        }
        material.add_aovs(&at, sums);
        material.passing(&at)
    }

    /// How a hit moves in the picture: from now to before, and from after to now, in its widths and heights.
    pub fn vectors(&self, hit: &Hit) -> [Vec2; 2] {
        let Some(views) = &self.views else {
            return [Vec2::ZERO; 2];
        };
        let at = |time: f32| {
            let mut moment = None;
            let (entry, mesh, triangle) =
                self.object_at::<General>(&Hit { time, ..*hit }, &mut moment);
            entry.point::<General>(mesh, triangle, hit.u, hit.v).point
        };
        views.of_points([at(0.0), at(hit.time), at(1.0)])
    }

    /// The same of what lies in a direction at infinity, if that counts.
    pub fn vectors_around(&self, direction: Vec3) -> Option<[Vec2; 2]> {
        match &self.views {
            Some(views) => views.of_direction(direction),
            None => Some([Vec2::ZERO; 2]),
        }
    }

    /// Adds what the light from all around tells passes of the scene's own.
    pub fn add_aovs_around(&self, direction: Vec3, sums: &mut [f64]) {
        if let Some(around) = &self.aovs {
            let kind = RayKind::Camera.bit();
            let point = ShinePoint::around(direction, LookingRay { kind, depth: 0 });
            around.add_aovs(&point, sums);
        }
    }

    /// Whether all light passes straight on at a hit, without a look at its material's program.
    #[inline]
    pub fn lets_all_pass(&self, hit: &Hit) -> bool {
        self.prepared(hit).lets_all_pass
    }

    /// Whether a hit is of what only bounds a medium: as in Cycles it counts as no surface that is passed.
    #[inline]
    pub fn only_bounds(&self, hit: &Hit) -> bool {
        self.prepared(hit).only_bounds
    }

    /// Whether what a path may pass at a hit shines.
    #[inline]
    pub fn glows_in_passing(&self, hit: &Hit) -> bool {
        self.prepared(hit).glows_in_passing
    }

    /// What passes straight on at a hit, as a colour, and the share of the rest; `None` where that takes no colour.
    #[cold]
    #[inline(never)]
    pub fn tint(&self, hit: &Hit, asking: Asking) -> Option<(Vec3, f32)> {
        let material = self.prepared(hit);
        material.is_tinted.then(|| {
            let mut moment = None;
            let (entry, mesh, triangle) = self.object_at::<General>(hit, &mut moment);
            let place = (triangle, hit.u, hit.v);
            let mut at = entry.at(mesh, place, asking);
            let is_shadow = asking.kind == RayKind::Shadow.bit();
            // Shadow rays ask while Embree traces them; Cycles has no rays there either.
            if !is_shadow {
                at.around = self.traces().then_some(self);
            }
            if is_shadow && material.has_portal() {
                return material.passing_to_light(&at, self.as_cycles);
            }
            material.passing(&at)
        })
    }

    /// How much of a hit holdouts among its shaders empty for rays of the camera; `None` where no shader is one.
    pub fn held_out(&self, hit: &Hit, asking: Asking) -> Option<f32> {
        self.tell(hit, asking, |material, at| material.held_out(at))
    }

    /// What a hit's material says of it to a ray that may ask the scene.
    fn tell<T>(
        &self,
        hit: &Hit,
        asking: Asking,
        say: impl FnOnce(&PreparedMaterial, &HitPoint<'_>) -> T,
    ) -> T {
        let mut moment = None;
        let (entry, mesh, triangle) = self.object_at::<General>(hit, &mut moment);
        let mut at = entry.at(mesh, (triangle, hit.u, hit.v), asking);
        at.around = self.traces().then_some(self);
        say(&self.materials[mesh.material as usize], &at)
    }

    #[inline]
    fn prepared(&self, hit: &Hit) -> &PreparedMaterial {
        let entry = &self.geometry.entries[hit.object() as usize];
        let mesh = &self.geometry.meshes[entry.mesh as usize];
        &self.materials[mesh.material as usize]
    }

    /// Whether paths stop at a hit, to decide for themselves what passes.
    #[inline]
    pub fn decides(&self, hit: &Hit) -> bool {
        self.prepared(hit).is_tinted
    }

    /// Whether a holdout may empty some of a hit where paths stop.
    #[inline]
    pub fn may_be_held_out(&self, hit: &Hit) -> bool {
        self.is_holdout(hit) || self.prepared(hit).has_holdout()
    }

    /// Whether a portal takes some of what is met at a hit that a path may pass.
    #[cold]
    #[inline(never)]
    pub fn is_portal(&self, hit: &Hit, asking: Asking) -> bool {
        self.tell(hit, asking, |material, at| {
            material.has_portal() && material.portal(at).is_some()
        })
    }

    /// Whether queries have to ask about hits. Where they don't, all kernels ask Embree the same: of two surfaces at
    /// the same distance the query that asks may find another than the one that does not.
    #[inline]
    fn filters<E: Features>(&self) -> bool {
        self.geometry.filtered && (E::EVERYTHING || self.cull_backfaces)
    }

    /// The nearest surface that the ray does not pass. Blended surfaces are met with the
    /// probability of their opacity, by the numbers of a path's bounce about what is met, so that the order in which
    /// Embree asks does not matter.
    #[inline]
    pub fn intersect<'p, E: Features>(
        &self,
        origin: Vec3,
        direction: Vec3,
        (near, far): (f32, f32),
        sender: impl Into<Sender<'p>>,
        numbers: (&Sampler, u32),
    ) -> Option<Hit> {
        let sender = sender.into();
        let ray = sent((origin, direction), (near, far), &sender);
        if !self.filters::<E>() {
            return self.nearest::<E>(&ray);
        }
        self.nearest_filtered::<E>(&ray, |hit| {
            let opacity = self.opacity::<E>(hit, direction, &sender);
            Self::stops(opacity, || number(hit, numbers))
        })
    }

    /// The nearest hit. Where faces lie on each other, Embree is asked as Cycles asks it: the last of several at one distance is
    /// found, so that of two objects in one place the later one is seen.
    #[inline]
    fn nearest<E: Features>(&self, ray: &Ray) -> Option<Hit> {
        if E::EVERYTHING && self.has_lids() {
            return self.geometry.embree.intersect_asking(ray, |_| true);
        }
        self.geometry.embree.intersect(ray)
    }

    /// The nearest hit that the filter accepts, which may be asked of filtered geometry alone.
    #[inline]
    fn nearest_filtered<E: Features>(
        &self,
        ray: &Ray,
        filter: impl FnMut(&Hit) -> bool,
    ) -> Option<Hit> {
        if E::EVERYTHING && self.has_lids() {
            return self.geometry.embree.intersect_asking(ray, filter);
        }
        self.geometry.embree.intersect_filtered(ray, filter)
    }

    /// As [`Self::intersect`], passing at most `left` surfaces.
    /// As Cycles counts: surfaces without any opacity too, but not back faces that are hidden.
    // Inlined as far as there is nothing to pass: what is found stays in registers.
    #[inline(always)]
    pub fn intersect_limited<E: Features>(
        &self,
        origin: Vec3,
        direction: Vec3,
        (near, far): (f32, f32),
        sender: Sender,
        numbers: (&Sampler, u32),
        left: u32,
    ) -> Intersection {
        let ray = sent((origin, direction), (near, far), &sender);
        if self.filters::<E>() {
            return self.intersect_passing::<E>(&ray, direction, &sender, (numbers, left));
        }
        let hit = self.nearest::<E>(&ray);
        hit.map_or(Intersection::Nothing, |hit| Intersection::Surface(hit, 0))
    }

    /// What a ray meets behind at most `left` surfaces that it passes.
    #[inline(never)]
    fn intersect_passing<E: Features>(
        &self,
        ray: &Ray,
        direction: Vec3,
        sender: &Sender,
        (numbers, left): ((&Sampler, u32), u32),
    ) -> Intersection {
        let mut passed = Vec::new();
        let hit = self.nearest_filtered::<E>(ray, |hit| {
            if self.is_hidden(hit, direction) || self.is_left(hit, sender.past.left) {
                return false;
            }
            let opacity = self.opacity::<E>(hit, direction, sender);
            let stops = Self::stops(opacity, || number(hit, numbers));
            if !stops {
                passed.push((hit.distance, hit.instance, hit.geometry, hit.primitive));
            }
            stops
        });
        // Embree asks in any order, about surfaces behind the hit as well.
        let end = hit.map_or(ray.far, |hit| hit.distance);
        passed.retain(|&(distance, ..)| distance <= end);
        passed.sort_unstable_by(|a, b| {
            a.0.total_cmp(&b.0)
                .then_with(|| (a.1, a.2, a.3).cmp(&(b.1, b.2, b.3)))
        });
        passed.dedup();
        if let Some(&(distance, ..)) = passed.get(left as usize) {
            return Intersection::Limit(distance);
        }
        hit.map_or(Intersection::Nothing, |hit| {
            Intersection::Surface(hit, passed.len() as u32)
        })
    }

    /// Whether something of this opacity stops a ray, by a number.
    #[inline]
    pub(super) fn stops(opacity: f32, number: impl FnOnce() -> f32) -> bool {
        opacity >= 1.0 || (opacity > 0.0 && number() < opacity)
    }

    /// Share of light that comes from `origin + direction · share` to `origin`, as a colour, 0..=1. Light that would
    /// have to pass more than `limit` surfaces does not come. `sender`: that of the shadow ray.
    #[inline]
    pub fn transmittance<E: Features>(
        &self,
        origin: Vec3,
        direction: Vec3,
        far: f32,
        (limit, sender): (u32, &Sender),
    ) -> Vec3 {
        let mut ray = shadow_ray((origin, direction), far, sender.time);
        if E::EVERYTHING && sender.blockers != 0 {
            ray.mask = sender.blockers;
        }
        if !self.filters::<E>() {
            return if self.geometry.embree.occluded(&ray) {
                Vec3::ZERO
            } else {
                Vec3::ONE
            };
        }
        let mut share = Share::within(limit);
        let blocked = self.geometry.embree.occluded_filtered(&ray, |hit| {
            self.dims::<E>(&mut share, hit, (direction, sender))
        });
        if blocked { Vec3::ZERO } else { share.light }
    }

    /// Takes from a shadow ray's light what a surface on its way does not let pass; whether none is left.
    #[inline]
    pub(super) fn dims<E: Features>(
        &self,
        share: &mut Share,
        hit: &Hit,
        (direction, sender): (Vec3, &Sender),
    ) -> bool {
        if E::EVERYTHING && self.is_left(hit, sender.past.left) {
            return false;
        }
        if !(E::EVERYTHING && self.lets_all_pass(hit)) {
            share.light *= match self
                .is_tinted()
                .then(|| self.tint(hit, Asking::of(sender, direction, hit)))
                .flatten()
            {
                Some((passes, _)) if !self.is_hidden(hit, direction) => passes,
                _ => Vec3::splat(1.0 - self.opacity::<E>(hit, direction, sender)),
            };
        }
        if let Some(left) = &mut share.left
            && !self.is_hidden(hit, direction)
            && !(E::EVERYTHING && self.only_bounds(hit))
        {
            if *left == 0 {
                share.light = Vec3::ZERO;
            }
            *left = left.saturating_sub(1);
        }
        share.light.max_element() <= 0.0
    }

    /// Share of light between two points with error bounds that see each other along `wi` (from
    /// `a` to `b`): both ends leave their surfaces by their bounds.
    #[inline]
    pub fn transmittance_to<E: Features>(
        &self,
        origin: Vec3,
        target: Vec3,
        limited: (u32, &Sender),
    ) -> Vec3 {
        self.transmittance::<E>(origin, target - origin, float::SHADOW_RAY_SHARE, limited)
    }
}

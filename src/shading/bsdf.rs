//! The BSDF at a point: a short list of lobes with weights.
//!
//! One lobe is drawn by its share of the albedo, and its direction is weighted by the density of the whole mixture. The
//! Lambertian lobe stands apart from the list: nearly every surface has it, and simple kernels have nothing else.

mod elsewhere;
mod fibres;
mod found;
mod kinds;
mod receiving;
mod roughness;
mod shares;
mod steeper;
mod turned;
mod uniform;

pub use elsewhere::Elsewhere;
pub use found::{BsdfSample, BsdfValue};
use steeper::steepened;

use super::closure::{AllFeatures, BsdfFeatures, Diffuse, Lobe, LobeSample, LobeValue, Normals};
use super::ggx::Alpha;
use crate::math::{Frame, average, warp};
use arrayvec::ArrayVec;
use glam::{Vec2, Vec3};
use std::marker::PhantomData;

/// Lobes that a surface may have beside the Lambertian one.
pub const MOST_LOBES: usize = 12;
/// A lobe whose albedo is estimated too low must not starve.
const LEAST_SHARE: f32 = 0.05;
/// Light samples bring other lobes the most of their light, and what goes on below the surface none: it is drawn so many times as
/// often for its albedo. On three icings 3 to 6 have the least noise: 0.5 to 0.75 of the relMSE that 1 has, in the same time.
const LIT_BY_WALKS_ALONE: f32 = 4.0;

/// A lobe of the list.
#[derive(Clone, Copy, Debug)]
struct Entry {
    lobe: Lobe,
    albedo: Vec3,
    /// Probability of being drawn.
    p: f32,
    /// All of its directions are found by sampling it alone.
    is_delta: bool,
    is_diffuse: bool,
    is_of_fibres: bool,
}

impl Entry {
    /// By which the lobes share the probability of being drawn.
    #[inline(always)]
    fn importance(&self) -> f32 {
        let by_walks = matches!(self.lobe, Lobe::Below(_));
        let light = self.lobe.passed_on().unwrap_or(self.albedo);
        average(light) * if by_walks { LIT_BY_WALKS_ALONE } else { 1.0 }
    }
}

/// How paths change what surfaces do.
#[derive(Clone, Copy, Debug)]
pub struct Changes {
    /// The least α of facets ("filter glossy").
    pub least_alpha: f32,
    /// What is reflected, and what goes through, is kept.
    pub caustics: [bool; 2],
    /// It has been scattered diffusely before.
    pub diffused: bool,
    /// Where directions are drawn, a bump's facets send light also to behind the smooth surface, as in Cycles.
    pub behind: bool,
    /// Light that is reflected counts as if its angle to a lobe's normal were so many times as great (see `steeper::steepened`).
    pub steeper: f32,
}

impl Changes {
    /// None.
    pub const NONE: Self = Self {
        least_alpha: 0.0,
        caustics: [true; 2],
        diffused: false,
        behind: false,
        steeper: 1.0,
    };
}

/// The BSDF at a point, seen from `wo`.
#[derive(Clone, Debug)]
pub struct Bsdf<K = AllFeatures> {
    kinds: PhantomData<K>,
    normals: Normals,
    wo: Vec3,
    /// The viewer is behind the surface.
    inside: bool,
    changes: Changes,
    lambert: Diffuse,
    others: ArrayVec<Entry, MOST_LOBES>,
    /// Some lobe lets light through.
    transmits: bool,
    /// Some lobe is lit from the other side.
    is_lit_behind: bool,
    /// Some lobe is of fibres.
    has_fibres: bool,
    /// Some lobe in the list is found by light sampling.
    is_samplable: bool,
    /// All lobes in the list have the normal of the surface.
    agrees: bool,
    /// Probability of the lobes in the list.
    p_others: f32,
    /// Lobes that found no room in the list.
    left_out: u32,
}

/// What a surface did to a path, as Cycles tells rays apart: diffuse and glossy reflection, and what
/// goes through to the other side (rough, clear or thin), or through a fibre.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scattering {
    /// Reflected by a diffuse lobe.
    Diffuse,
    /// Reflected by facets or a mirror.
    Glossy,
    /// Went through.
    Transmission,
}

/// Values and densities of the diffuse lobes, and of the others, each density times the lobe's probability. They are summed
/// apart: a difference of the sums would cancel.
#[derive(Clone, Copy, Debug)]
struct Sums {
    diffuse: LobeValue,
    others: LobeValue,
}

impl Sums {
    const ZERO: Self = Self {
        diffuse: LobeValue::ZERO,
        others: LobeValue::ZERO,
    };

    /// Adds a lobe that is drawn with probability `p`.
    #[inline]
    fn add(&mut self, of: LobeValue, p: f32, is_diffuse: bool) {
        let sum = if is_diffuse {
            &mut self.diffuse
        } else {
            &mut self.others
        };
        sum.value += of.value;
        sum.pdf += p * of.pdf;
    }

    /// All of them; without facets there are none but diffuse ones.
    #[inline(always)]
    fn total(&self, facets: bool) -> BsdfValue {
        if !facets {
            return BsdfValue {
                value: self.diffuse.value,
                diffuse: self.diffuse.value,
                pdf: self.diffuse.pdf,
                diffuse_pdf: self.diffuse.pdf,
            };
        }
        BsdfValue {
            value: self.diffuse.value + self.others.value,
            diffuse: self.diffuse.value,
            pdf: self.diffuse.pdf + self.others.pdf,
            diffuse_pdf: self.diffuse.pdf,
        }
    }
}

impl<K: BsdfFeatures> Bsdf<K> {
    /// A surface without any lobe, as the path wants to see it; [`Self::finish`] is due when lobes are added.
    #[inline(always)]
    pub fn new(normals: Normals, wo: Vec3, inside: bool, changes: Changes) -> Self {
        Self {
            kinds: PhantomData,
            normals,
            wo,
            inside,
            changes,
            lambert: Diffuse {
                color: Vec3::ZERO,
                normal: normals.shading,
            },
            others: ArrayVec::new_const(),
            transmits: false,
            is_lit_behind: false,
            has_fibres: false,
            is_samplable: false,
            agrees: true,
            p_others: 0.0,
            left_out: 0,
        }
    }

    /// How many lobes found no room, as [`MOST_LOBES`] others weigh more.
    pub fn left_out(&self) -> u32 {
        self.left_out
    }

    /// Adds a Lambertian lobe. Those with one normal are one.
    #[inline]
    pub fn add_lambert(&mut self, color: Vec3, normal: Vec3) {
        if !K::FACETS || self.lambert.color == Vec3::ZERO {
            self.lambert = Diffuse { color, normal };
            return;
        }
        if self.lambert.normal == normal {
            self.lambert.color += color;
            return;
        }
        self.add(Lobe::Diffuse(Diffuse { color, normal }), color);
    }

    /// Adds a lobe with its mean reflectance and transmittance for the view. A Principled BSDF has four at most.
    #[inline(always)]
    pub(super) fn add(&mut self, lobe: Lobe, albedo: Vec3) {
        self.transmits |= lobe.transmits();
        self.is_lit_behind |= lobe.is_lit_behind();
        let is_of_fibres = lobe.is_of_fibres();
        self.has_fibres |= is_of_fibres;
        self.agrees &= lobe.normal() == self.normals.shading;
        let entry = Entry {
            is_delta: lobe.is_delta(),
            is_diffuse: lobe.is_diffuse(),
            is_of_fibres,
            lobe,
            albedo,
            p: 0.0,
        };
        self.is_samplable |= !entry.is_delta;
        if let Err(full) = self.others.try_push(entry) {
            self.crowd(full.element());
        }
    }

    /// Of more lobes than there is room for, those of the least albedo are left out.
    #[cold]
    #[inline(never)]
    fn crowd(&mut self, entry: Entry) {
        self.left_out += 1;
        let weight = |entry: &Entry| average(entry.albedo);
        let least = self.others.iter_mut();
        let least = least.min_by(|a, b| weight(a).total_cmp(&weight(b)));
        if let Some(least) = least.filter(|least| weight(least) < weight(&entry)) {
            *least = entry;
        }
    }

    /// Shares the probabilities out, when all lobes are added.
    #[inline]
    pub fn finish(&mut self) {
        if !K::FACETS || self.others.is_empty() {
            return;
        }
        let b = average(self.lambert.color);
        if let ([entry], true) = (&mut self.others[..], b <= 0.0) {
            (self.p_others, entry.p) = (1.0, 1.0);
            return;
        }
        let a = self.others.iter().map(Entry::importance).sum::<f32>();
        self.p_others = if b <= 0.0 {
            1.0
        } else {
            (a / (a + b)).clamp(LEAST_SHARE, 1.0 - LEAST_SHARE)
        };
        if let [entry] = &mut self.others[..] {
            entry.p = self.p_others;
        } else {
            self.share_out(a);
        }
    }

    /// Shares the probability of the list out among its lobes, whose importances have the sum `all`.
    #[cold]
    fn share_out(&mut self, all: f32) {
        let share = |entry: &Entry| {
            let share = if all > 0.0 {
                entry.importance() / all
            } else {
                0.0
            };
            share.max(LEAST_SHARE)
        };
        let sum: f32 = self.others.iter().map(share).sum();
        for entry in &mut self.others {
            entry.p = self.p_others * (share(entry) / sum);
        }
    }

    /// How the path changes what it does.
    pub(super) fn changes(&self) -> Changes {
        self.changes
    }

    /// The Lambertian lobe.
    pub(super) fn lambert(&self) -> Diffuse {
        self.lambert
    }

    /// The same about the normal that it has here.
    #[inline(always)]
    fn base(&self) -> Diffuse {
        Diffuse {
            normal: self.normal(),
            ..self.lambert
        }
    }

    /// The lobes in the list, and the albedo of each.
    pub(super) fn lobes(&self) -> impl Iterator<Item = (Lobe, Vec3)> {
        self.others.iter().map(|entry| (entry.lobe, entry.albedo))
    }

    /// The normals of the surface.
    #[inline]
    pub(super) fn normals(&self) -> &Normals {
        &self.normals
    }

    /// Direction to the viewer.
    #[inline]
    pub(super) fn wo(&self) -> Vec3 {
        self.wo
    }

    /// Whether the viewer is behind the surface.
    #[inline]
    pub(super) fn is_inside(&self) -> bool {
        self.inside
    }

    /// Facets at least as rough as the path wants them. As in Cycles all else stays as of the material's own roughness, also
    /// what multiple scattering gives back: a mirror that is made rough loses light.
    #[inline]
    pub(super) fn roughened(&self, alpha: Alpha) -> Alpha {
        let least = self.changes.least_alpha;
        if alpha.xy.min_element() < least {
            Alpha::anisotropic(alpha.xy.max(Vec2::splat(least)))
        } else {
            alpha
        }
    }

    /// Whether what is reflected, and what goes through, is kept on this path.
    #[inline]
    pub(super) fn keeps_caustics(&self) -> [bool; 2] {
        self.changes.caustics
    }

    /// Whether what is reflected is kept on this path.
    #[inline]
    pub(super) fn keeps_reflections(&self) -> bool {
        self.changes.caustics[0]
    }

    /// Probability of the lobes in the list.
    #[inline(always)]
    fn p_others(&self) -> f32 {
        if K::FACETS { self.p_others } else { 0.0 }
    }

    /// The lobes in the list.
    #[inline(always)]
    fn others(&self) -> &[Entry] {
        if K::FACETS { &self.others } else { &[] }
    }

    /// Whether some lobe lets light through.
    #[inline(always)]
    fn transmits(&self) -> bool {
        K::TRANSMISSION && self.transmits
    }

    /// Normal of the Lambertian lobe.
    #[inline(always)]
    fn normal(&self) -> Vec3 {
        if K::BUMPS {
            self.lambert.normal
        } else {
            self.smooth()
        }
    }

    /// Smooth normal.
    #[inline(always)]
    fn smooth(&self) -> Vec3 {
        if K::SMOOTH {
            self.normals.smooth
        } else {
            self.normals.geometric
        }
    }

    /// Smooth normal of the corners, which no displacement has bent.
    #[inline(always)]
    fn curved(&self) -> Vec3 {
        if K::BUMPS {
            self.normals.curved
        } else {
            self.smooth()
        }
    }

    /// Diffuse colour plus mean reflectance and transmittance: what denoisers call albedo.
    pub fn albedo(&self) -> Vec3 {
        self.lambert.color + self.albedo_of_others()
    }

    /// Sum of the albedos in the list.
    #[inline(always)]
    fn albedo_of_others(&self) -> Vec3 {
        let mut all = Vec3::ZERO;
        for entry in self.others() {
            all += entry.albedo;
        }
        all
    }

    /// Normal of each lobe, what it scatters with its tint, and the α of its facets: 1 of lobes without any.
    pub fn facets(&self) -> impl Iterator<Item = (Vec3, Vec3, f32)> {
        let lambert = (self.normal(), self.lambert.color, 1.0);
        let others = self.others().iter().map(|Entry { lobe, albedo, .. }| {
            let [reflected, transmitted] = lobe.colors(*albedo);
            (lobe.normal(), reflected + transmitted, lobe.alpha())
        });
        std::iter::once(lambert).chain(others)
    }

    /// Bound of the weights of [`sample`](Self::sample), to be checked where they arise. The weight of a mixture is at
    /// most the greatest of its lobes', each over its probability. The rest is for roundings.
    pub fn max_sample_weight(&self) -> f32 {
        let over = |weight: f32, p: f32| if p > 0.0 { weight / p } else { 0.0 };
        let mut most = over(self.lambert.color.max_element(), 1.0 - self.p_others());
        for entry in self.others() {
            most = most.max(over(entry.lobe.max_sample_weight(), entry.p));
        }
        1.001 * most
    }

    /// Whether some light could be found by sampling lights (not only by sampling the BSDF).
    #[inline]
    pub fn is_samplable(&self) -> bool {
        self.lambert.color != Vec3::ZERO || (K::FACETS && self.is_samplable)
    }

    /// BSDF · |cos| and the density for a direction to the light.
    #[inline]
    pub fn evaluate(&self, wi: Vec3) -> BsdfValue {
        if self.is_below(wi) {
            return BsdfValue::ZERO;
        }
        self.sums(usize::MAX, wi, self.is_beyond(wi))
            .total(K::FACETS)
    }

    /// The same for the direction of a light that Cycles samples: with [`Lobe::evaluate_backs`], and what only a displacement
    /// that is a bump sees.
    #[inline]
    pub fn evaluate_sampled(&self, wi: Vec3) -> BsdfValue {
        if self.has_fibres() {
            return self.evaluate_sampled_fibres(wi);
        }
        if !self.is_beyond(wi) {
            if self.is_below(wi) && !self.is_seen_by_bump(wi) {
                return BsdfValue::ZERO;
            }
            let mut sums = self.sums(usize::MAX, wi, false);
            if K::BUMPS && self.transmits() {
                for entry in self.others() {
                    let of = entry.lobe.evaluate_before::<K>(self.smooth(), wi);
                    sums.add(of, entry.p, entry.is_diffuse);
                }
            }
            return sums.total(K::FACETS);
        }
        let mut sums = self.sums(usize::MAX, wi, true);
        for entry in self.others().iter().filter(|entry| !entry.is_delta) {
            let of = entry.lobe.evaluate_backs::<K>(self.smooth(), wi);
            sums.add(of, entry.p, entry.is_diffuse);
        }
        sums.total(K::FACETS)
    }

    /// Of the Lambertian lobe, as [`Self::sums`] has it.
    #[inline]
    fn value_of_base(&self, wi: Vec3) -> LobeValue {
        let lambert = self.base();
        let bumped = K::BUMPS && lambert.normal != self.smooth();
        lambert.evaluate((self.smooth(), bumped), wi)
    }

    /// The same for a direction that is not below the surface, without one lobe of the list.
    #[inline]
    fn sums(&self, left_out: usize, wi: Vec3, transmitted: bool) -> Sums {
        if self.is_steeper() {
            return self.steeper_sums(left_out, wi, transmitted);
        }
        self.sums_by::<false>(left_out, wi, transmitted)
    }

    #[inline(always)]
    fn sums_by<const STEEPER: bool>(&self, left_out: usize, wi: Vec3, transmitted: bool) -> Sums {
        let left = |value: Vec3, normal: Vec3| match STEEPER {
            true => value * steepened(wi.dot(normal), self.changes.steeper),
            false => value,
        };
        let mut sums = Sums::ZERO;
        if !transmitted {
            let of = self.known(self.base().normal, self.value_of_base(wi));
            sums.diffuse = LobeValue {
                value: left(of.value, self.base().normal),
                pdf: (1.0 - self.p_others()) * of.pdf,
            };
        }
        for (i, entry) in self.others().iter().enumerate() {
            if i != left_out && !entry.is_delta {
                let mut of = entry.lobe.evaluate::<K>(self.smooth(), wi, transmitted);
                if entry.is_diffuse {
                    of = self.known(entry.lobe.normal(), of);
                }
                if STEEPER {
                    of.value = left(of.value, entry.lobe.normal());
                }
                sums.add(of, entry.p, entry.is_diffuse);
            }
        }
        sums
    }

    /// Whether a direction is beyond the surface, for what lets light through: on the other side of the triangle.
    #[inline]
    pub fn is_beyond(&self, wi: Vec3) -> bool {
        self.transmits() && wi.dot(self.normals.geometric) < 0.0
    }

    /// Whether a direction is below a surface that lets no light through. On the curved surface that the triangles stand
    /// for it is above as long as the smooth normal says so, even where the triangle looks away already: else coarse meshes
    /// have black facets along the terminator, and lose energy. A displacement that is a bump bends no surface: what only its
    /// normal sees is lost, as in Cycles. Where the smooth normal points to the other side, it tells nothing of this one.
    #[inline]
    pub fn is_below(&self, wi: Vec3) -> bool {
        if self.transmits() || wi.dot(self.normals.geometric) >= 0.0 {
            return false;
        }
        let curved = self.curved();
        wi.dot(curved) <= 0.0 || curved.dot(self.normals.geometric) <= 0.0
    }

    /// Whether a direction is above a displacement that is a bump, of a surface that looks to the viewer's side. Cycles samples
    /// lights there: whether a ray from the curved surface gets to them its way tells.
    #[inline]
    fn is_seen_by_bump(&self, wi: Vec3) -> bool {
        K::BUMPS && wi.dot(self.smooth()) > 0.0 && self.curved().dot(self.normals.geometric) > 0.0
    }

    /// Draws a direction: z chooses the lobe, and between reflection and transmission.
    #[inline]
    pub fn sample(&self, u: Vec3) -> Option<BsdfSample> {
        let (u, mut choice) = (u.truncate(), u.z);
        if K::FACETS && choice < self.p_others() {
            let last = self.others.len() - 1;
            for (i, entry) in self.others.iter().enumerate() {
                if choice < entry.p || i == last {
                    return self.sample_lobe(i, entry, u, (choice / entry.p).min(1.0));
                }
                choice -= entry.p;
            }
        }
        if self.lambert.color == Vec3::ZERO {
            return None;
        }
        let wi = Frame::from_normal(self.normal()).to_world(warp::cosine_hemisphere(u));
        if self.is_below(wi) || self.is_beyond(wi) {
            return None;
        }
        let mut sums = self.sums(usize::MAX, wi, false);
        if self.is_turned(self.normal()) {
            self.add_lost(wi, &mut sums.diffuse);
        }
        Self::weigh(wi, (Scattering::Diffuse, false), &sums)
    }

    /// The smooth normal behind which a lobe draws no direction.
    #[inline(always)]
    fn smooth_of(&self, entry: &Entry) -> Vec3 {
        if K::BUMPS && self.changes.behind && !entry.is_diffuse {
            entry.lobe.normal()
        } else {
            self.smooth()
        }
    }

    /// Draws a direction from a lobe of the list.
    #[inline(always)]
    fn sample_lobe(&self, index: usize, entry: &Entry, u: Vec2, choice: f32) -> Option<BsdfSample> {
        let LobeSample {
            wi,
            transmitted,
            delta,
            mut of,
        } = entry.lobe.sample::<K>(self.smooth_of(entry), u, choice)?;
        let beyond = self.is_beyond(wi);
        if self.is_below(wi) || beyond != transmitted && !entry.is_of_fibres {
            return None;
        }
        let scattering = entry.lobe.scattering(transmitted);
        if self.is_steeper() {
            of.value *= steepened(wi.dot(entry.lobe.normal()), self.changes.steeper);
        }
        if delta {
            let weight = of.value / (of.pdf * entry.p);
            return Some(BsdfSample {
                wi,
                weight,
                diffuse: Vec3::ZERO,
                pdf: 0.0,
                delta,
                beyond,
                scattering,
                alone: (weight, 0.0),
                is_as_diffuse: false,
                is_translucent: false,
                alpha: 0.0,
            });
        }
        // Surfaces of glass or metal alone have no other lobe.
        let is_alone = self.others.len() == 1 && self.lambert.color == Vec3::ZERO;
        let mut sums = if is_alone {
            Sums::ZERO
        } else {
            self.sums(index, wi, beyond)
        };
        sums.add(of, entry.p, entry.is_diffuse);
        let sample = Self::weigh(wi, (scattering, beyond), &sums)?;
        Some(BsdfSample {
            is_as_diffuse: self.is_as_diffuse(scattering, &sums, choice),
            is_translucent: K::TRANSMISSION && matches!(entry.lobe, Lobe::Translucent(_)),
            alpha: if K::TRANSMISSION && beyond {
                entry.lobe.alpha()
            } else {
                1.0
            },
            ..sample
        })
    }

    /// The weight of a sampled direction under the whole mixture.
    #[inline]
    fn weigh(
        wi: Vec3,
        (scattering, beyond): (Scattering, bool),
        sums: &Sums,
    ) -> Option<BsdfSample> {
        let kind = if scattering == Scattering::Diffuse {
            &sums.diffuse
        } else {
            &sums.others
        };
        let v = sums.total(K::FACETS);
        (v.pdf > 0.0).then(|| BsdfSample {
            wi,
            weight: v.value / v.pdf,
            diffuse: v.diffuse / v.pdf,
            pdf: v.pdf,
            delta: false,
            beyond,
            scattering,
            alone: (kind.value / kind.pdf, kind.pdf),
            is_as_diffuse: false,
            is_translucent: false,
            alpha: 1.0,
        })
    }
}

#[cfg(test)]
#[path = "../../tests/unit/shading/bsdf.rs"]
mod tests;

//! One highlight of fibres, about a cone around them: Blender's Hair BSDF, in the manner of Marschner et al., *Light Scattering from
//! Human Hair Fibers*, 2003. Along the fibre half angles have a Cauchy distribution, and the albedo is the colour.
//!
//! As in Cycles directions are drawn without a look at the side that they are on, and some go where no evaluation finds light. Those
//! of a reflection tell a density that is not theirs, where the roughness around is not 1: by half of the turn, not of the turn over the
//! roughness. What lights and directions share hangs on that.

use super::{LobeSample, LobeValue};
use glam::{Vec2, Vec3};
use std::f32::consts::{FRAC_PI_2, PI};

/// Directions as near as this to the fibre's own get nothing, radians: the density is unbounded there.
const NEAREST: f32 = 1e-3;

/// A highlight of fibres.
#[derive(Clone, Copy, Debug)]
pub struct Hair {
    /// Weight of the lobe.
    pub(super) weight: Vec3,
    /// The lobe's own normal.
    normal: Vec3,
    /// Along the fibre.
    tangent: Vec3,
    /// To the viewer, across the fibre.
    toward: Vec3,
    /// How far the view leans from across the fibre to along it, radians.
    view: f32,
    /// The cone's angle.
    offset: f32,
    /// Along the fibre and around it.
    roughness: Vec2,
    /// Arc tangents of the ends of half angles, over the roughness, and how far they are apart.
    from: f32,
    span: f32,
    /// It is of what goes through.
    transmits: bool,
}

/// A direction, as a fibre sees it.
struct Around {
    /// How far it leans from across the fibre to along it, radians.
    lean: f32,
    /// How far it is from the view around the fibre, 0 to π.
    turn: f32,
}

impl Hair {
    /// About a normal and a tangent; `offset` is the cone's angle, `roughness` along the fibre and around it. None for a view along
    /// the fibre.
    pub fn new(
        weight: Vec3,
        (normal, tangent): (Vec3, Vec3),
        wo: Vec3,
        (offset, roughness): (f32, Vec2),
        transmits: bool,
    ) -> Option<Self> {
        let along = tangent.dot(wo);
        let across = wo - tangent * along;
        let toward = across.try_normalize()?;
        let view = along.atan2(across.length());
        let roughness = roughness.clamp(Vec2::splat(0.001), Vec2::ONE);
        let end = |half: f32| ((0.5 * (half + view) - offset) / roughness.x).atan();
        let from = end(-FRAC_PI_2);
        Some(Self {
            weight,
            normal,
            tangent,
            toward,
            view,
            offset,
            roughness,
            from,
            span: end(FRAC_PI_2) - from,
            transmits,
        })
    }

    /// The lobe's own normal.
    pub fn normal(&self) -> Vec3 {
        self.normal
    }

    /// Whether it is of what goes through.
    pub fn is_through(&self) -> bool {
        self.transmits
    }

    fn around(&self, wi: Vec3) -> Around {
        let along = self.tangent.dot(wi);
        let across = wi - self.tangent * along;
        let beside = self.tangent.cross(self.toward).dot(across);
        Around {
            lean: along.atan2(across.length()),
            turn: beside.atan2(self.toward.dot(across)).abs(),
        }
    }

    /// Density per solid angle, on whichever side; all of the light goes by it.
    fn density(&self, of: &Around) -> f32 {
        if FRAC_PI_2 - of.lean.abs() < NEAREST {
            return 0.0;
        }
        let Vec2 { x: u, y: v } = self.roughness;
        let t = 0.5 * (of.lean + self.view) - self.offset;
        let along = u / (2.0 * (t * t + u * u) * self.span * of.lean.cos());
        let around = if self.transmits {
            let p = PI - of.turn;
            v / (2.0 * (FRAC_PI_2 / v).atan() * (p * p + v * v))
        } else {
            (0.5 * (of.turn / v).min(PI)).cos().max(0.0) * 0.25 / v
        };
        along * around
    }

    /// Whether light is evaluated in a direction, and whether directions are drawn there.
    fn meets(&self, wi: Vec3, of: &Around) -> (bool, bool) {
        let above = self.normal.dot(wi) >= 0.0;
        let near = of.turn <= FRAC_PI_2;
        match self.transmits {
            true => (!above, !near),
            false => (above && near, true),
        }
    }

    fn value(&self, of: &Around) -> LobeValue {
        let pdf = self.density(of);
        let value = self.weight * pdf;
        LobeValue { value, pdf }
    }

    /// Value and density.
    pub fn evaluate(&self, wi: Vec3) -> LobeValue {
        let of = self.around(wi);
        match self.meets(wi, &of) {
            (true, true) => self.value(&of),
            _ => LobeValue::ZERO,
        }
    }

    /// Light that is evaluated where no direction is drawn.
    pub fn evaluate_backs(&self, wi: Vec3) -> LobeValue {
        let of = self.around(wi);
        match self.meets(wi, &of) {
            (true, false) => self.value(&of),
            _ => LobeValue::ZERO,
        }
    }

    /// Draws a direction by its density.
    pub fn sample(&self, u: Vec2) -> Option<LobeSample> {
        let v = self.roughness.y;
        let t = self.roughness.x * (u.x * self.span + self.from).tan();
        let lean = 2.0 * (t + self.offset) - self.view;
        let turn = if self.transmits {
            PI + v * (2.0 * (FRAC_PI_2 / v).atan() * (u.y - 0.5)).tan()
        } else {
            2.0 * (1.0 - 2.0 * u.y).clamp(-1.0, 1.0).asin() * v
        };
        let (along, across) = lean.sin_cos();
        let (beside, toward) = turn.sin_cos();
        let beside = self.tangent.cross(self.toward) * beside;
        let wi = (self.toward * toward + beside) * across + self.tangent * along;
        let wi = wi.try_normalize()?;
        let around = self.around(wi);
        let mut of = self.value(&around);
        if !self.transmits && of.pdf > 0.0 {
            let told = (0.5 * turn).cos().abs() / (0.5 * turn / v).cos().abs().max(1e-6);
            of.pdf *= told;
            of.value *= told;
        }
        LobeSample::reflected(wi, of).map(|sample| LobeSample {
            transmitted: self.transmits,
            ..sample
        })
    }
}

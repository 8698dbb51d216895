//! Blender's Radial Tiling: the plane in segments about the origin, each as wide as one side of a polygon with rounded corners.
//!
//! The number of sides may have a fraction: the last segment is then narrower. A segment's own coordinates are how far one is
//! along its middle, whose polygon of inradius 1 is at 1, and to the side of it.

use glam::{Vec2, Vec3};
use std::f32::consts::{PI, TAU};

use super::mix;

/// What the node gives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RadialTilingOutputs {
    /// Segment Coordinates, whose third is 0.
    pub coordinates: Vec2,
    /// Segment ID, from 0 on counterclockwise.
    pub id: f32,
    /// Segment Width: half of it, where the polygon of inradius 1 is.
    pub width: f32,
    /// Segment Rotation: the angle from the x axis to the segment's middle.
    pub rotation: f32,
}

/// What a side is, from its middle to a corner: a straight part, and a bevel that ends at the border of the segment. The
/// length along the bevel is a spline near the corner, so that it is smooth from the straight part on.
#[derive(Clone, Copy)]
struct Bevel {
    /// The angle of the bevel, up to the segment's border.
    start: f32,
    /// The angle of the straight part, from the middle.
    middle: f32,
    /// The angle of the spline.
    spline: f32,
    /// The angle of the arc, which is the rest of the bevel.
    arc: f32,
}

impl Bevel {
    /// Of a segment's half angle, the bevel's angle, and how much of the bevel is an arc.
    fn new(half: f32, start: f32, roundness: f32) -> Self {
        Self {
            start,
            middle: half - start,
            spline: (1.0 - roundness) * start,
            arc: roundness * start,
        }
    }

    /// Of a corner between two sides alike.
    fn between(half: f32, roundness: f32) -> Self {
        // Without a bevel there is none by rounding, either.
        let start = if roundness == 0.0 {
            0.0
        } else {
            half - ((1.0 - roundness) * half.tan()).atan()
        };
        Self::new(half, start, roundness)
    }

    /// Half of the width of the polygon that is so far from the origin along its middle.
    fn width(self, level: f32) -> f32 {
        level * self.middle.tan() + self.spline * (0.5 * level + 0.5) + self.arc
    }

    /// The same of a point in the bevel that is itself so far away.
    fn width_at(self, distance: f32) -> f32 {
        distance * self.middle.sin()
            + self.spline * (0.5 * distance * self.middle.cos() + 0.5)
            + self.arc
    }

    /// The way from the middle to a point in the bevel, by its distance from the origin and its angle from the bevel's start.
    fn way(self, distance: f32, angle: f32) -> f32 {
        let along = distance * self.middle.cos();
        let bent = if angle.max(0.0) < self.spline {
            along * angle + 0.5 * (1.0 - along) * angle * angle / self.spline
        } else {
            self.spline * (0.5 * along - 0.5) + angle
        };
        distance * self.middle.sin() + bent
    }

    /// Half of the width beside which that way lies: at the bevel's start that of straight parts.
    fn width_in(self, level: f32, distance: f32, angle: f32) -> f32 {
        mix(
            self.width(level),
            self.width_at(distance),
            angle / self.start,
        )
    }
}

/// The circle that rounds the corners of the last segment, whose neighbours are wider.
struct LastCircle {
    center: Vec2,
    radius: f32,
}

impl LastCircle {
    fn new(half: f32, last_half: f32, last: &Bevel, roundness: f32) -> Self {
        let radius = roundness * last_half.tan() / (0.5 * (half + last_half)).tan();
        let (sin, cos) = last_half.sin_cos();
        let (start_sin, start_cos) = last.start.sin_cos();
        let side = (last_half - last.start).cos();
        let center = Vec2::new(
            start_cos / side - radius * cos,
            radius * sin - start_sin / side,
        );
        Self { center, radius }
    }

    /// Where a ray from the origin leaves it.
    fn distance(&self, angle: f32) -> f32 {
        let (sin, cos) = angle.sin_cos();
        let along = sin * self.center.y + cos * self.center.x;
        along + (along * along + self.radius * self.radius - self.center.length_squared()).sqrt()
    }
}

/// Where a point is in its segment.
struct Place {
    /// How far the polygon of the point is from the origin, along the segment's middle.
    level: f32,
    /// The way to the middle, without its sign.
    way: f32,
    /// Half of the width of the polygon there.
    whole: f32,
    /// Half of the width of the polygon of inradius 1.
    width: f32,
    /// Half of the segment's angle.
    half: f32,
}

/// The place in a segment like its neighbours; `angle` from the segment's border, `outer` the bevel beside the last segment.
fn regular(
    (half, roundness): (f32, f32),
    (distance, angle): (f32, f32),
    is_straight: bool,
    outer: Option<&Bevel>,
) -> Place {
    let bevel = Bevel::between(half, roundness);
    let width = bevel.width(1.0);
    if is_straight {
        let level = distance * (half - angle).cos();
        return Place {
            level,
            way: level * (half - angle).abs().tan(),
            whole: outer.unwrap_or(&bevel).width(level),
            width,
            half,
        };
    }
    let from_border = if angle > half {
        angle - 2.0 * half
    } else {
        angle
    };
    let to_circle = (1.0 - roundness) / half.cos();
    let along = from_border.cos() * to_circle;
    let end = along + (along * along + roundness * roundness - to_circle * to_circle).sqrt();
    let level = distance / end;
    let in_bevel = bevel.start - from_border.abs();
    Place {
        level,
        way: bevel.way(distance, in_bevel),
        whole: bevel.width_in(level, distance, in_bevel),
        width,
        half,
    }
}

/// The place where all segments are alike.
fn of_whole_sides(sides: f32, roundness: f32, distance: f32, angle: f32) -> Place {
    let half = PI / sides;
    if roundness == 0.0 && sides == 2.0 {
        // Parallels have no width: nothing is normalised.
        let level = distance * (half - angle).cos();
        return Place {
            level,
            way: level * (half - angle).abs().tan(),
            whole: 1.0,
            width: 0.0,
            half,
        };
    }
    let start = Bevel::between(half, roundness).start;
    let is_straight = roundness == 0.0 || (angle >= start && angle < 2.0 * half - start);
    regular((half, roundness), (distance, angle), is_straight, None)
}

/// The place where the last segment is narrower; `turn` is the angle from the x axis.
fn of_broken_sides(
    sides: f32,
    roundness: f32,
    (point, distance): (Vec2, f32),
    (turn, angle): (f32, f32),
) -> Place {
    let half = PI / sides;
    let last_half = PI - sides.floor() * half;
    let last_border = TAU - 2.0 * last_half;
    // Lengths in the last segment are shown as those of the others.
    let ratio = half.cos() / last_half.cos();
    let (bevel, inner) = (
        Bevel::between(half, roundness),
        Bevel::between(last_half, roundness),
    );
    let circle = LastCircle::new(half, last_half, &inner, roundness);
    let outer_start = if roundness == 0.0 {
        0.0
    } else {
        let start = circle.center + circle.radius * Vec2::new(half.cos(), half.sin());
        (start.y / start.x).atan()
    };
    let outer_roundness = 1.0 - (half - outer_start).tan() / half.tan();
    let outer = Bevel::new(half, outer_start, outer_roundness);

    let is_regular = if roundness == 0.0 {
        turn < last_border
    } else {
        turn >= outer_start && turn < last_border - outer_start
    };
    if is_regular {
        let is_straight = roundness == 0.0
            || (angle >= bevel.start && angle < 2.0 * half - bevel.start)
            || turn >= last_border - bevel.start
            || turn < bevel.start;
        let is_beside = turn >= last_border - half || turn < half;
        let outer = is_beside.then_some(&outer);
        return regular((half, roundness), (distance, angle), is_straight, outer);
    }
    let last_width =
        inner.middle.tan() + ratio * (inner.spline * (0.5 / ratio + 0.5) + roundness * inner.start);
    if roundness == 0.0 || (turn >= last_border + inner.start && turn < TAU - inner.start) {
        let last_level = distance * (last_half - angle).cos();
        let level = ratio * last_level;
        return Place {
            level,
            way: level * (last_half - angle).abs().tan(),
            whole: ratio * inner.width(last_level),
            width: last_width,
            half: last_half,
        };
    }
    // Both borders of the last segment are one, seen from its middle: inwards the angle is negative.
    let mut from_border = point.y.atan2(point.x);
    if turn >= last_border - outer_start && turn < TAU - last_half {
        from_border = -(from_border + 2.0 * last_half);
    }
    let last_level = distance / circle.distance(from_border);
    let level = ratio * last_level;
    if from_border < 0.0 {
        let in_bevel = inner.start - from_border.abs();
        Place {
            level,
            way: ratio * inner.way(distance, in_bevel),
            whole: ratio * inner.width_in(last_level, distance, in_bevel),
            width: last_width,
            half: last_half,
        }
    } else {
        let in_bevel = outer.start - from_border.abs();
        Place {
            level,
            way: outer.way(distance, in_bevel),
            whole: outer.width_in(level, distance, in_bevel),
            width: bevel.width(1.0),
            half,
        }
    }
}

/// The node's outputs. With `normalize` the way to the side goes from 0 to 1 over each segment, and the other begins at the
/// origin; without it is a length, and the other begins at the polygon of inradius 1.
pub fn radial_tiling(
    normalize: bool,
    vector: Vec3,
    sides: f32,
    roundness: f32,
) -> RadialTilingOutputs {
    let (sides, roundness) = (sides.max(2.0), roundness.clamp(0.0, 1.0));
    let point = vector.truncate();
    let distance = point.length();
    let is_below = f32::from(point.y < 0.0);
    let turn = point.y.atan2(point.x) + is_below * TAU;
    let whole_angle = 2.0 * (PI / sides);
    let border = (turn / whole_angle).floor() * whole_angle;
    let angle = turn - border;
    let place = if sides == sides.floor() {
        of_whole_sides(sides, roundness, distance, angle)
    } else {
        of_broken_sides(sides, roundness, (point, distance), (turn, angle))
    };
    let mut way = if point == Vec2::ZERO {
        0.0
    } else if angle < place.half {
        -place.way
    } else {
        place.way
    };
    let mut level = place.level;
    if normalize {
        if point != Vec2::ZERO {
            way /= place.whole;
        }
        way = 0.5 * way + 0.5;
    } else {
        level -= 1.0;
    }
    // Two sides with round corners have no polygon. Cycles' film leaves out that number alone, Sundog's would leave out all.
    if level.is_nan() && !way.is_nan() {
        level = 0.0;
    }
    RadialTilingOutputs {
        coordinates: Vec2::new(way, level),
        id: (sides * (point.y.atan2(point.x) / TAU + is_below)).floor(),
        width: place.width,
        rotation: border + place.half,
    }
}

#[cfg(test)]
#[path = "../../tests/unit/nodes/radial_tiling.rs"]
mod tests;

use super::*;

/// Points near the origin, far from it, and where the lattice is left.
fn numbers() -> impl Iterator<Item = f32> {
    let near = (0..2000).map(|number| number as f32 * 0.0137 - 11.0);
    near.chain([
        -0.0,
        1e5,
        -1e5,
        123_456.7,
        2e6,
        f32::MAX,
        f32::INFINITY,
        f32::NAN,
    ])
}

/// The same noise whatever vectors the processor has.
fn dispatches<const N: usize>()
where
    Point<N>: Noise,
{
    for x in numbers() {
        let p = || Point::<N>::from_axes(|axis| x * (axis as f32 + 0.7) + axis as f32);
        let (plain, vectors) = (Offsets(p()).call(), on_vectors(Offsets(p())));
        let bits = |p: Point<N>| p.0.to_array().map(f32::to_bits);
        let are_nan = plain.0.to_array().iter().any(|x| x.is_nan());
        assert!(
            are_nan || bits(plain) == bits(vectors),
            "{N} dimensions at {x}"
        );
    }
}

#[test]
fn vectors_of_the_processor_change_no_noise() {
    dispatches::<1>();
    dispatches::<2>();
    dispatches::<3>();
    dispatches::<4>();
}

/// Perlin's noise corner by corner, as his paper has it.
fn corner_by_corner(axes: &Axes) -> f32 {
    let corner = |i: usize, j: usize, k: usize| {
        let ((i, x), (j, y), (k, z)) = (axes.side(0, i), axes.side(1, j), axes.side(2, k));
        let hash = hash::words_3(i, j, k) & 15;
        let u = if hash < 8 { x } else { y };
        let v = match hash {
            0..4 => y,
            12 | 14 => x,
            _ => z,
        };
        let sign = |bit: u32, value: f32| if hash & bit == 0 { value } else { -value };
        sign(1, u) + sign(2, v)
    };
    let [x, y, z, _] = axes.fades;
    let along_x = |j, k| mix(corner(0, j, k), corner(1, j, k), x);
    let along_y = |k| mix(along_x(0, k), along_x(1, k), y);
    mix(along_y(0), along_y(1), z)
}

#[test]
fn corners_in_vectors_are_those_one_by_one() {
    for x in numbers().filter(|x| x.abs() < 1e6) {
        let p = f32x4::new([x, 0.3 - x * 0.71, x * 1.9 + 0.1, 0.0]);
        let axes = axes(p, wrap_by_quotient);
        assert_eq!(
            gradients_3(&axes).to_bits(),
            corner_by_corner(&axes).to_bits(),
            "{x}"
        );
    }
}

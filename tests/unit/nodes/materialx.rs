use super::*;

/// A place; Perlin's noise, three octaves of it (2.1 times as fine, 0.6 as high), Worley's distances and cells with a jitter of 0.8, each
/// in two and in three dimensions; numbers of cells, in both as well, of the place and of the nearest point.
type Row = ([f32; 3], [[f32; 3]; 8], [f32; 4]);

/// What MaterialX 1.39.5's own code says (libraries/stdlib/genglsl/lib/mx_noise.glsl, compiled as C++).
const VALUES: [Row; 5] = [
    (
        [0.3, 0.7, 0.2],
        [
            [0.04074368, 0.6510122, -0.3023903],
            [0.2737119, -0.1883346, 0.4048614],
            [-0.2314642, 1.08659, 0.00419423],
            [0.4732769, -0.3184878, 0.4564991],
            [0.5358595, 0.6358139, 0.9964854],
            [0.3967101, 0.8402585, 0.9206737],
            [0.6110677, 0.1858238, 0.04130607],
            [0.111573, 0.3250999, 0.3399473],
        ],
        [0.8603128, 0.6110677, 0.8603128, 0.6110677],
    ),
    (
        [-1.6, 2.45, 7.9],
        [
            [-0.6622521, 0.219156, 0.2740708],
            [0.1659108, 0.04936917, -0.1639786],
            [-0.8261828, 0.1060032, 0.1810375],
            [0.5054514, -0.03389558, -0.1276698],
            [0.5058641, 0.8525513, 1.054507],
            [0.6407132, 0.7852729, 0.7987123],
            [0.9262238, 0.7473285, 0.4198947],
            [0.9275625, 0.4331562, 0.4202737],
        ],
        [0.5628883, 0.4573528, 0.5628883, 0.4573528],
    ),
    (
        [12.25, -33.1, 0.5],
        [
            [0.2096851, 0.06939497, -0.1444173],
            [0.01598871, -0.296748, 0.3532118],
            [0.7239749, 0.3150251, -0.2261735],
            [0.1086856, -0.3327414, 0.383669],
            [0.1794811, 0.5834373, 0.6501546],
            [0.3806826, 0.7746661, 0.8014906],
            [0.1888666, 0.7756547, 0.2397351],
            [0.2628339, 0.6429912, 0.8054578],
        ],
        [0.3231596, 0.1888666, 0.3231596, 0.1888666],
    ),
    (
        [5.5, 5.25, -5.75],
        [
            [0.0227748, -0.5931141, 0.6672533],
            [-0.08376176, -0.08631515, -0.267913],
            [0.3222816, -0.5580224, 1.066397],
            [-0.1475841, -0.006314687, 0.2321659],
            [0.09707944, 0.40328, 0.8565499],
            [0.286793, 0.6366547, 0.8233339],
            [0.3928134, 0.1306081, 0.06893755],
            [0.799992, 0.3678481, 0.2649294],
        ],
        [0.6743922, 0.1883124, 0.6743922, 0.1883124],
    ),
    (
        [-0.01, 0.99, 100.3],
        [
            [0.01985423, -0.006615863, 0.01985384],
            [0.141064, 0.1442741, 0.2547733],
            [0.1721152, -0.1194923, 0.1001176],
            [-0.1536365, 0.4586802, 0.2938007],
            [0.7220574, 0.766757, 0.9530019],
            [0.7137146, 0.756172, 0.7716568],
            [0.2295562, 0.04970603, 0.4723401],
            [0.3758722, 0.3903754, 0.9963014],
        ],
        [0.1141141, 0.6889604, 0.4956739, 0.6616009],
    ),
];

#[test]
fn noises_are_those_of_materialx() {
    for (place, triples, singles) in VALUES {
        for flat in [true, false] {
            let of = |noise: LatticeNoise, octaves: f32| {
                let inputs = LatticeInputs {
                    vector: place.into(),
                    jitter: 0.8,
                    octaves,
                    lacunarity: 2.1,
                    diminish: 0.6,
                };
                lattice_noise(LatticeSettings { noise, flat }, &inputs)
            };
            let perlin = [1.0, 3.0].map(|octaves| of(LatticeNoise::Perlin, octaves).0);
            let (distances, least) = of(LatticeNoise::Worley, 1.0);
            let (numbers, number) = of(LatticeNoise::WorleyCell, 1.0);
            let (_, cell) = of(LatticeNoise::Cell, 1.0);
            assert_eq!(least, distances.x);
            let found = [perlin[0], perlin[1], distances, numbers];
            let second = usize::from(!flat);
            for (at, found) in found.iter().enumerate() {
                let expected = Vec3::from(triples[2 * at + second]);
                // Coordinates are rounded elsewhere: of 100 by 8e-6, and thrice that in the third octave.
                let far = (*found - expected).abs().max_element();
                assert!(far < 2e-5, "{place:?} {flat} {at}: {found} {expected}");
            }
            for (found, expected) in [(cell, singles[second]), (number, singles[2 + second])] {
                assert!((found - expected).abs() < 1e-6, "{place:?} {flat}");
            }
        }
    }
}

#[test]
fn what_is_no_number_is_no_panic() {
    for noise in [
        LatticeNoise::Cell,
        LatticeNoise::Worley,
        LatticeNoise::WorleyCell,
        LatticeNoise::Perlin,
    ] {
        for x in [f32::NAN, f32::INFINITY, -3e38] {
            for flat in [true, false] {
                let inputs = LatticeInputs {
                    vector: Vec3::new(x, 0.5, x),
                    jitter: x,
                    octaves: x,
                    lacunarity: x,
                    diminish: x,
                };
                let _ = lattice_noise(LatticeSettings { noise, flat }, &inputs);
            }
        }
    }
}

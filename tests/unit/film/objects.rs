use super::*;

/// Hashes and numbers that Blender 5.2.3 has written into the manifests and passes of its own files.
#[test]
fn hashes_are_cryptomattes() {
    for (name, expected) in [
        ("Cube", 0xa8fc_e865),
        ("Floor", 0x6a2f_b16e),
        ("default_surface", 0x78d0_5529),
        ("Material", 0x3913_209d),
        ("", 0),
    ] {
        assert_eq!(hash(name), expected, "{name}");
    }
    // An exponent of 0 or of 255 is made another; the rest are bits as they are.
    assert_eq!(id_float(0xa8fc_e865).to_bits(), 0xa8fc_e865);
    assert_eq!(id_float(0x0000_1234).to_bits(), 0x0080_1234);
    assert_eq!(id_float(0xff80_0001).to_bits(), 0xff00_0001);
    assert!(id_float(0x7fff_ffff).is_finite());
}

fn of(number: u32, weight: f32) -> FirstObject {
    FirstObject {
        number,
        weight,
        there: weight,
        distance: 10.0,
        ..FirstObject::default()
    }
}

fn pixel(samples: &[(u32, f32)]) -> PixelObjects {
    let mut pixel = PixelObjects::default();
    for &(number, weight) in samples {
        pixel.add(&of(number, weight), Mist::default());
    }
    pixel
}

fn labels() -> Vec<Label> {
    let label = |object: &str, material| Label::new([object, material, "a"], [0.0; 2]);
    vec![label("a", "m"), label("b", "m"), label("c", "n")]
}

#[test]
fn the_largest_share_comes_first_and_parts_of_one_name_are_one() {
    let pixel = pixel(&[(0, 1.0), (2, 1.0), (1, 1.0), (2, 1.0), (2, 1.0), (1, 0.5)]);
    let [id, share, next, next_share] = pixel.mattes(&labels(), Matte::Object, 0, 0.125);
    assert_eq!((id, share), (id_float(hash("c")), 0.375));
    assert_eq!((next, next_share), (id_float(hash("b")), 0.1875));
    let last = pixel.mattes(&labels(), Matte::Object, 2, 0.125);
    assert_eq!(last, [id_float(hash("a")), 0.125, 0.0, 0.0]);
    // Objects 0 and 1 have one material: 2.5 of 8 samples against 3.
    let [id, share, _, next_share] = pixel.mattes(&labels(), Matte::Material, 0, 0.125);
    assert_eq!(
        (id, share, next_share),
        (id_float(hash("n")), 0.375, 0.3125)
    );
    let asset = pixel.mattes(&labels(), Matte::Asset, 0, 0.125);
    assert_eq!(asset, [id_float(hash("a")), 0.6875, 0.0, 0.0]);
}

#[test]
fn parts_joined_are_the_whole_in_any_order() {
    let samples = [(0, 0.3), (1, 0.7), (2, 0.1), (0, 0.9), (1, 0.2)];
    let whole = pixel(&samples);
    for at in 0..samples.len() {
        let (mut a, b) = (pixel(&samples[at..]), pixel(&samples[..at]));
        a.join(&b);
        for rank in [0, 2] {
            let of = |pixel: &PixelObjects| pixel.mattes(&labels(), Matte::Object, rank, 0.2);
            assert_eq!(of(&a), of(&whole), "{at}");
        }
        assert_eq!(a.mist(0.2), whole.mist(0.2));
    }
}

#[test]
fn what_no_slot_is_left_for_goes_to_the_last() {
    let many: Vec<(u32, f32)> = (0..40).map(|number| (number, 1.0)).collect();
    let pixel = pixel(&many);
    assert!(pixel.is_sound(40) && !pixel.is_sound(15));
    assert_eq!(pixel.weights.iter().sum::<i64>(), 40 << 32);
}

/// Blender's default: 5 to 30 metres, squared.
#[test]
fn mist_is_blenders() {
    let at = |distance| Mist::default().at(distance);
    assert_eq!(
        [at(5.0), at(17.5), at(30.0), at(1e9)],
        [0.0, 0.25, 1.0, 1.0]
    );
    let edge = Mist {
        depth: 0.0,
        ..Mist::default()
    };
    assert_eq!([edge.at(4.0), edge.at(6.0)], [0.0, 1.0]);
    // 10 metres are a fifth of the way. Half of the samples see nothing.
    let pixel = pixel(&[(0, 1.0)]);
    assert!((pixel.mist(0.5) - 0.52).abs() < 1e-6);
}

#[test]
fn indices_are_those_of_the_middle() {
    let labels = [Label::new(["a", "m", "a"], [7.0, 3.0])];
    let mut pixel = PixelObjects::default();
    assert_eq!([false, true].map(|m| pixel.index(&labels, m)), [0.0; 2]);
    pixel.set_middle(Some(0));
    assert_eq!([false, true].map(|m| pixel.index(&labels, m)), [7.0, 3.0]);
}

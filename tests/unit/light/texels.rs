use super::*;

fn shared(texels: &[Vec3]) -> Texels {
    Texels::from(texels.to_vec()).packed()
}

/// What Radiance's files can say is packed, and has the same bits afterwards.
#[test]
fn numbers_of_radiance_files_are_packed_to_the_bit() {
    let mut texels = vec![Vec3::ZERO];
    for exponent in [10, 64, 127, 128, 129, 200, 254] {
        for bytes in [[255, 0, 1], [128, 255, 3], [1, 0, 0], [90, 17, 201]] {
            let unit = 2f64.powi(exponent - 136);
            let color = bytes.map(|byte| (f64::from(byte) * unit) as f32);
            // A smaller mantissa takes a smaller exponent: not below the least.
            if exponent > 20 || bytes.iter().any(|&byte| byte >= 128) {
                texels.push(Vec3::from(color));
            }
        }
    }
    let packed = shared(&texels);
    assert!(matches!(packed, Texels::Packed(_)));
    for (i, &texel) in texels.iter().enumerate() {
        assert_eq!(
            packed.at(i).to_array().map(f32::to_bits),
            texel.to_array().map(f32::to_bits)
        );
    }
}

/// Whatever else there is in an image, it keeps all of its bits.
#[test]
fn other_numbers_stay_as_they_are() {
    for odd in [
        Vec3::new(0.1, 0.2, 0.3),
        Vec3::new(1.0, 257.0, 0.0),
        Vec3::new(-1.0, 0.0, 0.0),
        Vec3::new(-0.0, 1.0, 0.0),
        Vec3::new(1.0, 1e-3, 0.0),
        Vec3::splat(f32::MAX),
        Vec3::splat(f32::MIN_POSITIVE),
        Vec3::splat(1e-44),
        Vec3::new(f32::INFINITY, 0.0, 0.0),
        Vec3::new(1.0, f32::NAN, 0.0),
        Vec3::NAN,
    ] {
        let plain = shared(&[Vec3::ONE, odd]);
        assert!(matches!(plain, Texels::Plain(_)), "{odd}");
        assert_eq!(
            plain.at(1).to_array().map(f32::to_bits),
            odd.to_array().map(f32::to_bits)
        );
    }
}

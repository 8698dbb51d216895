use super::*;
use crate::film::{Layer, Picture};

#[test]
fn packets_are_as_the_protocol_says() {
    let names = ["R".to_owned(), "Z".to_owned()];
    assert_eq!(
        create_image("a\0b", (3, 258), &names),
        b"\x19\0\0\0\x04\x01ab\0\x03\0\0\0\x02\x01\0\0\x02\0\0\0R\0Z\0"[..],
    );
    let packet = update_rows("a", &names[..1], 5, 1, &[1.0, -2.0]);
    let mut expected = b"\0\0\0\0\x06\0a\0\x01\0\0\0R\0".to_vec();
    for number in [0u32, 5, 1, 2] {
        expected.extend(number.to_le_bytes());
    }
    expected.extend(0u64.to_le_bytes());
    expected.extend(1u64.to_le_bytes());
    expected.extend([0, 0, 0x80, 0x3f, 0, 0, 0, 0xc0]);
    expected[0] = expected.len() as u8;
    assert_eq!(packet, expected);
}

#[test]
fn a_picture_goes_band_by_band_until_nobody_wants_it() {
    let layer = |name: &str, channels: &[&str]| Layer {
        name: name.into(),
        channels: channels.iter().map(|c| (*c).into()).collect(),
        data: (0..40 * 2 * channels.len()).map(|i| i as f32).collect(),
    };
    let picture = Picture {
        width: 2,
        height: 40,
        layers: vec![
            layer("Combined", &["R", "G", "B", "A"]),
            layer("Depth", &["Z"]),
        ],
    };
    let mut packets = Vec::new();
    update("a", &picture, &mut |packet| {
        packets.push(packet);
        packets.len() < 3
    });
    assert_eq!(packets.len(), 3);
    let z = ["Depth.Z".to_owned()];
    assert_eq!(
        packets[1],
        update_rows("a", &z, 0, 2, &picture.layers[1].data[..64])
    );
    let rgba = ["R", "G", "B", "A"].map(String::from);
    let rest = &picture.layers[0].data[256..];
    assert_eq!(packets[2], update_rows("a", &rgba, 32, 2, rest));
}

#[test]
fn addresses() {
    for (text, expected) in [
        ("localhost", "localhost:14158"),
        ("viewer.example:80", "viewer.example:80"),
        ("127.0.0.1:65535", "127.0.0.1:65535"),
        ("[::1]", "[::1]:14158"),
        ("[::1]:7", "[::1]:7"),
    ] {
        assert_eq!(text.parse(), Ok(Address(expected.into())), "{text}");
    }
    for wrong in [
        "", ":", ":80", "a:", "a:0", "a:65536", "a:b", "::1", "a b", "[::1", "a:80:80",
    ] {
        assert!(wrong.parse::<Address>().is_err(), "{wrong}");
    }
}

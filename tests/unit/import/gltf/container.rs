use super::*;

#[test]
fn data_uris_are_decoded_with_and_without_base64() {
    assert_eq!(
        decode_data_uri("application/octet-stream;base64,AAEC").unwrap(),
        [0, 1, 2]
    );
    assert_eq!(
        decode_data_uri("application/octet-stream;base64,AAECAw").unwrap(),
        [0, 1, 2, 3]
    );
    assert_eq!(decode_data_uri("text/plain,a%20b").unwrap(), b"a b");
    assert!(decode_data_uri("no comma").is_err());
    assert!(decode_data_uri(";base64,@@@").is_err());
}

#[test]
fn glb_headers_of_every_length_are_refused_without_panic() {
    let mut glb = b"glTF\x02\0\0\0".to_vec();
    for length in [0u32, 1, 11, 12, 13, 19, 20, 24, u32::MAX] {
        glb.truncate(8);
        glb.extend(length.to_le_bytes());
        glb.extend(b"\xff\xff\xff\xffJSON");
        for cut in 0..=glb.len() {
            assert!(split_glb(&glb[..cut]).is_err());
        }
    }
}

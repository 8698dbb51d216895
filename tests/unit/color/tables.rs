use super::*;
use std::io::Write;

const BEGUN: &str = "CSPLUTV100\n3D\n\nBEGIN METADATA\na word\n";

#[test]
fn metadata_of_cinespace_tables_have_to_end() {
    let endless = |text: &str| has_endless_metadata(text.as_bytes()).unwrap();
    assert!(endless(BEGUN));
    assert!(endless(&BEGUN.to_lowercase()));
    assert!(endless(&format!("{BEGUN}END METADAT\n")));
    assert!(!endless(&format!("{BEGUN} end metadata\n3\n")));
    assert!(!endless("CSPLUTV100\n3D\n\n3\n"));
    // Of another kind, whatever it says.
    assert!(!endless(&BEGUN[11..]));
}

#[test]
fn tables_of_archives_are_looked_at() {
    let file = tempfile::NamedTempFile::new().unwrap();
    let mut archive = zip::ZipWriter::new(file.reopen().unwrap());
    let options =
        zip::write::SimpleFileOptions::default().compression_method(zip::CompressionMethod::Stored);
    for (name, text) in [("config.ocio", "nothing"), ("luts/a.cube", BEGUN)] {
        archive.start_file(name, options).unwrap();
        archive.write_all(text.as_bytes()).unwrap();
    }
    archive.finish().unwrap();
    let (name, reason) = fault_in_archive(file.path()).unwrap();
    assert_eq!(
        (&*name, &*reason),
        ("luts/a.cube", "its metadata have no end")
    );
    let empty = tempfile::NamedTempFile::new().unwrap();
    assert!(fault(empty.path(), 0).is_none());
    assert_eq!(fault(empty.path(), 1 << 30).unwrap(), "it has 1024 MiB");
}

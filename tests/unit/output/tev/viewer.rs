use super::*;
use crate::film::{Layer, Passes, Picture};

fn combined() -> Vec<(String, String)> {
    Passes::COMBINED.layers().collect()
}

#[test]
fn reasons_are_words() {
    let system = io::Error::from_raw_os_error(111);
    assert_eq!(reason(&system), "nobody listens there");
    let other = io::Error::from_raw_os_error(101);
    assert!(!reason(&other).contains("os error"), "{}", reason(&other));
    assert_eq!(
        reason(&connect("", PATIENCE).unwrap_err()),
        connect("", PATIENCE).unwrap_err().to_string()
    );
}

/// More than the system keeps for a connection: the viewer has to read to get it all.
fn large() -> Picture {
    let (width, height) = (2048, 2048);
    Picture {
        width,
        height,
        layers: vec![Layer {
            name: "Combined".into(),
            channels: ["R", "G", "B", "A"].map(String::from).to_vec(),
            data: vec![0.5; (4 * width * height) as usize],
        }],
    }
}

/// Longer than a test takes, however busy the machine: who waits this long waits for ever.
const FOREVER: Duration = Duration::from_secs(3600);

/// A viewer for this picture at a place that accepts connections and reads nothing.
fn deaf(picture: &Picture, patience: Duration) -> (Viewer, std::net::TcpListener) {
    let listener = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap().to_string();
    let size = (picture.width, picture.height);
    let viewer = Viewer::patient(&address, "a", size, &combined(), patience);
    (viewer, listener)
}

#[test]
fn no_picture_is_made_for_a_viewer_that_has_not_got_the_last() {
    let picture = large();
    let (viewer, _listener) = deaf(&picture, FOREVER);
    viewer.show(&picture);
    viewer.timing().due = Instant::now();
    assert!(!viewer.is_due(&|_| ()));
    assert_eq!(viewer.shared.post().failure, None);
    assert!(!viewer.timing().told);
}

#[test]
fn a_viewer_that_does_not_read_is_left_alone() {
    let picture = large();
    let (viewer, _listener) = deaf(&picture, Duration::from_millis(300));
    viewer.finish(&picture, &|_| ());
    let failure = viewer.shared.post().failure.clone();
    assert_eq!(failure.as_deref(), Some("it does not answer"));
    assert!(viewer.timing().told);
}

#[test]
fn a_slow_viewer_gets_all_of_the_last_picture() {
    let listener = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap().to_string();
    let reading = std::thread::spawn(move || {
        let mut stream = listener.accept().unwrap().0;
        let (mut bytes, mut buffer) = (0, vec![0; 1 << 22]);
        loop {
            match std::io::Read::read(&mut stream, &mut buffer).unwrap() {
                0 => return bytes,
                n => bytes += n,
            }
            std::thread::sleep(Duration::from_millis(2));
        }
    });
    let picture = large();
    let size = (picture.width, picture.height);
    let viewer = Viewer::patient(&address, "a", size, &combined(), FOREVER);
    viewer.finish(&picture, &|_| ());
    assert_eq!(viewer.shared.post().failure, None);
    let mut sent = crate::output::tev::create("a", size, [("Combined", "RGBA")].into_iter()).len();
    crate::output::tev::update("a", &picture, &mut |packet| {
        sent += packet.len();
        true
    });
    assert_eq!(reading.join().unwrap(), sent);
}

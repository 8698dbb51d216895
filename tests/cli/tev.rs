//! `--tev`: what a viewer gets, read here independently of the code that writes it (from tev's `Ipc.cpp`).

use super::{Folder, interrupt};
use serde_json::Value;
use std::collections::BTreeMap;
use std::io::{BufRead, Read};
use std::net::{TcpListener, TcpStream};
use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::mpsc;

/// The rest of a packet.
struct Reader<'a>(&'a [u8]);

impl Reader<'_> {
    fn bytes<const N: usize>(&mut self) -> [u8; N] {
        let (first, rest) = self.0.split_at(N);
        self.0 = rest;
        first.try_into().unwrap()
    }

    fn int(&mut self) -> usize {
        usize::try_from(i32::from_le_bytes(self.bytes())).unwrap()
    }

    fn long(&mut self) -> usize {
        usize::try_from(i64::from_le_bytes(self.bytes())).unwrap()
    }

    fn text(&mut self) -> String {
        let end = self.0.iter().position(|byte| *byte == 0).unwrap();
        let text = std::str::from_utf8(&self.0[..end]).unwrap().to_owned();
        self.0 = &self.0[end + 1..];
        text
    }

    fn texts(&mut self, count: usize) -> Vec<String> {
        (0..count).map(|_| self.text()).collect()
    }
}

/// What tev would show.
#[derive(Default)]
struct Shown {
    name: String,
    width: usize,
    height: usize,
    channels: BTreeMap<String, Vec<f32>>,
    /// Channels that were set from the first to the last row, in the order in which that happened.
    whole: Vec<Vec<String>>,
}

impl Shown {
    fn packet(&mut self, packet: &[u8]) {
        let mut reader = Reader(&packet[4..]);
        let [operation, focus] = reader.bytes();
        let image = reader.text();
        match operation {
            4 => {
                assert_eq!((focus, self.width), (1, 0), "one image, once");
                self.name = image;
                (self.width, self.height) = (reader.int(), reader.int());
                let count = reader.int();
                let zeros = vec![0.0; self.width * self.height];
                let names = reader.texts(count).into_iter();
                self.channels = names.map(|name| (name, zeros.clone())).collect();
                assert_eq!(self.channels.len(), count, "names are unique");
            }
            6 => {
                assert_eq!((focus, &image), (0, &self.name));
                let count = reader.int();
                let names = reader.texts(count);
                let [x, y, width, height] = std::array::from_fn(|_| reader.int());
                let offsets: Vec<_> = names.iter().map(|_| reader.long()).collect();
                let strides: Vec<_> = names.iter().map(|_| reader.long()).collect();
                assert!(x + width <= self.width && y + height <= self.height);
                let values: Vec<f32> = std::mem::take(&mut reader.0)
                    .chunks(4)
                    .map(|bytes| f32::from_le_bytes(bytes.try_into().unwrap()))
                    .collect();
                for ((name, offset), stride) in names.iter().zip(&offsets).zip(&strides) {
                    let channel = self.channels.get_mut(name).unwrap();
                    for i in 0..width * height {
                        channel[(y + i / width) * self.width + x + i % width] =
                            values[offset + i * stride];
                    }
                }
                assert_eq!(values.len(), width * height * count);
                if y + height == self.height {
                    self.whole.push(names);
                }
            }
            _ => panic!("operation {operation}"),
        }
        assert!(reader.0.is_empty(), "{} bytes too many", reader.0.len());
    }
}

/// The next packet; none at the end.
fn next_packet(stream: &mut TcpStream) -> Option<Vec<u8>> {
    let mut packet = vec![0; 4];
    if stream.read(&mut packet[..1]).unwrap() == 0 {
        return None;
    }
    stream.read_exact(&mut packet[1..]).unwrap();
    let length = u32::from_le_bytes(packet[..4].try_into().unwrap());
    packet.resize(length as usize, 0);
    stream.read_exact(&mut packet[4..]).unwrap();
    Some(packet)
}

/// A viewer: where it listens, and what it has been told in the end. Says when so many whole pictures are there.
fn viewer(pictures: usize) -> (String, mpsc::Receiver<()>, std::thread::JoinHandle<Shown>) {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap().to_string();
    let (tell, told) = mpsc::channel();
    let listening = std::thread::spawn(move || {
        let mut stream = listener.accept().unwrap().0;
        let mut shown = Shown::default();
        while let Some(packet) = next_packet(&mut stream) {
            shown.packet(&packet);
            if shown.whole.len() == pictures {
                let _ = tell.send(());
            }
        }
        shown
    });
    (address, told, listening)
}

/// All channels of an EXR file by their names.
fn channels(file: &Path) -> BTreeMap<String, Vec<f32>> {
    let image = exr::prelude::read_first_flat_layer_from_file(file).unwrap();
    let list = image.layer_data.channel_data.list;
    list.into_iter()
        .map(|channel| {
            let values = channel.sample_data.values_as_f32().collect();
            (channel.name.to_string(), values)
        })
        .collect()
}

#[test]
fn the_viewer_has_all_that_the_file_has() {
    let folder = Folder::with_scene();
    let (address, _, listening) = viewer(1);
    let tev = format!("--tev={address}");
    folder.renders(&["-o", "a.exr", "--height=70", "--region=1,2,23,68", &tev]);
    let shown = listening.join().unwrap();
    assert_eq!(
        (shown.name.as_str(), shown.width, shown.height),
        ("a.exr", 22, 66)
    );
    assert_eq!(shown.channels, channels(&folder.path("a.exr")));
    assert_eq!(shown.channels.len(), 13, "all passes");
}

/// A render that does not end by itself, for a viewer.
#[cfg(unix)]
fn endless(folder: &Folder, address: &str) -> Command {
    let mut command = folder.command(&["render", "scene.gltf", "-o", "a.exr", "--width=24"]);
    command.args(["--time=10m", "--tev", address]);
    command.stderr(Stdio::null());
    command
}

#[cfg(unix)]
#[test]
fn the_viewer_sees_the_picture_grow() {
    let folder = Folder::with_scene();
    let (address, told, listening) = viewer(3);
    let mut child = endless(&folder, &address).spawn().unwrap();
    told.recv().unwrap();
    interrupt(&child);
    assert_eq!(child.wait().unwrap().code(), Some(130));
    let shown = listening.join().unwrap();
    assert_eq!(
        shown.whole[..3],
        vec![["R", "G", "B", "A"].map(String::from).to_vec(); 3]
    );
    assert_eq!(shown.channels, channels(&folder.path("a.exr")));
}

/// The warnings among events.
fn warnings(events: impl Iterator<Item = String>) -> Vec<String> {
    let events = events.map(|line| serde_json::from_str::<Value>(&line).unwrap());
    events
        .filter(|event| event["event"] == "warning")
        .map(|event| event["message"].as_str().unwrap().to_owned())
        .collect()
}

#[test]
fn without_a_viewer_the_picture_is_the_same() {
    let folder = Folder::with_scene();
    folder.renders(&["-o", "a.exr"]);
    // A port that was free a moment ago.
    let free = TcpListener::bind("127.0.0.1:0")
        .unwrap()
        .local_addr()
        .unwrap();
    let events = folder.renders(&["-o", "b.exr", "--json", &format!("--tev={free}")]);
    assert_eq!(
        warnings(events.lines().map(String::from)),
        [format!(
            "--tev: {free} does not show the picture: nobody listens there; the render does without it"
        )]
    );
    assert_eq!(
        channels(&folder.path("a.exr")),
        channels(&folder.path("b.exr"))
    );
}

#[cfg(unix)]
#[test]
fn a_viewer_that_goes_away_is_told_once() {
    let folder = Folder::with_scene();
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap().to_string();
    let mut child = endless(&folder, &address)
        .arg("--json")
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let mut stream = listener.accept().unwrap().0;
    // It goes with words unread, as if it had crashed.
    stream.read_exact(&mut [0]).unwrap();
    drop((stream, listener));
    let mut lines = std::io::BufReader::new(child.stdout.take().unwrap())
        .lines()
        .map(Result::unwrap);
    let warning = lines.find(|line| line.contains("\"warning\"")).unwrap();
    assert!(warning.contains("it has gone away"), "{warning}");
    // The render goes on.
    assert!(lines.any(|line| line.contains("\"progress\"")));
    interrupt(&child);
    assert_eq!(warnings(lines), Vec::<String>::new());
    assert_eq!(child.wait().unwrap().code(), Some(130));
    assert!(folder.path("a.exr").exists());
}

/// tev's own client in Python (PyPI's `tevclient`) makes the same bytes of the same calls.
#[test]
fn packets_equal_those_of_tevs_own_client() {
    use sundog::output::tev::{create_image, update_rows};
    let names = ["R", "G", "B", "A", "Debug Sample Count.X"].map(String::from);
    let values: Vec<f32> = (0..7 * 3 * 5).map(|i| (i as f32 - 20.0) / 3.0).collect();
    let ours = [
        create_image("Schnee – 雪.exr", (1280, 720), &names),
        update_rows("Schnee – 雪.exr", &names, 301, 7, &values),
        update_rows("a b.exr", &names[..1], 0, 35, &values),
    ];
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/python/tev_packets.py");
    let client = crate::pictures::cache().join("tevclient-1.0.4");
    assert!(
        client.is_dir(),
        "scripts/setup-tevclient.sh fetches {}",
        client.display()
    );
    let output = Command::new(crate::pictures::python())
        .arg(script)
        .env("PYTHONPATH", client)
        .output()
        .unwrap();
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    assert!(ours.concat() == output.stdout, "the bytes differ");
}

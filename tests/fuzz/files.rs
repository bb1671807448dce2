//! Damaged files for the readers of the command line: frame files, images, point clouds.

use crate::cloud::CloudFile;
use crate::frame::Frame;
use crate::memory::{held, most_held, reset_most_held};
use crate::random_views::Dice;
use crate::{setting, watch};
use std::path::{Path, PathBuf};

/// Files by default.
const FILES: u64 = 101_000;

/// The most memory that reading one of these files may take: they have less than 2 kilobytes, and so may images claim no more
/// than the camera of the frame file, which may be damaged itself.
const MOST_MEMORY: isize = 64 << 20;

const FRAMES: [&str; 2] = ["frame.json", "views.json"];
const IMAGES: [(&str, &str); 6] = [
    ("depth.png", "frame.json"),
    ("mask.png", "frame.json"),
    ("image.png", "frame.json"),
    ("grey.jpg", "views.json"),
    ("colour.jpg", "views.json"),
    ("palette.png", "views.json"),
];
const CLOUDS: [&str; 7] = [
    "points.xyz",
    "text.ply",
    "little_endian.ply",
    "big_endian.ply",
    "text.pcd",
    "binary.pcd",
    "compressed.pcd",
];

/// The statuses of a failure that are not those of the library.
const OWN_STATUSES: [&str; 6] =
    ["FILE_NOT_READABLE", "BAD_FRAME", "BAD_IMAGE", "IMAGE_TOO_LARGE", "SIZE_MISMATCH", "BAD_CLOUD"];
const LIBRARY_STATUSES: [&str; 3] = ["INVALID_INTRINSICS", "INVALID_ARGUMENT", "OUT_OF_MEMORY"];

/// Words that stand for a number in a text.
const WORDS: [&[u8]; 14] = [
    b"nan",
    b"-inf",
    b"1e999",
    b"-1",
    b"0",
    b"4294967296",
    b"18446744073709551616",
    b"99999999999",
    b"1e-320",
    b"268435456",
    b"\"\"",
    b"null",
    b"[]",
    b"0x10",
];

fn damaged(dice: &mut Dice, file: &[u8], other: &[u8]) -> Vec<u8> {
    let mut bytes = file.to_vec();
    for _ in 0..1 + dice.below(3) {
        if bytes.is_empty() {
            break;
        }
        // Headers decide more than what follows.
        let range = if dice.one_in(2) { bytes.len().min(300) } else { bytes.len() };
        let at = dice.below(range);
        let most = if dice.one_in(3) { 200 } else { 8 };
        let length = 1 + dice.below(most).min(bytes.len() - at - 1);
        match dice.below(10) {
            0 => bytes[at] ^= 1 << dice.below(8),
            1 => bytes[at] = [0, 1, 0x7f, 0x80, 0xff, b'-', b'\n', b' '][dice.below(8)],
            2 => bytes.truncate(at),
            3 => drop(bytes.drain(at..at + length)),
            4 => {
                let copy = bytes[at..at + length].to_vec();
                for _ in 0..1 + dice.below(4) {
                    bytes.splice(at..at, copy.iter().copied());
                }
            }
            5 => {
                let from = dice.below(other.len());
                let to = (from + length).min(other.len());
                bytes.splice(at..at + length, other[from..to].iter().copied());
            }
            6 => {
                let value = [0, 1, u32::MAX, 1 << 31, 1 << 28, 1 << 16][dice.below(6)];
                let value: u32 = if dice.one_in(2) { value } else { u32::from_be(value) };
                let end = (at + 4).min(bytes.len());
                bytes[at..end].copy_from_slice(&value.to_be_bytes()[..end - at]);
            }
            _ => {
                // The number at that place or after it.
                let is_digit = |byte: &u8| byte.is_ascii_digit() || *byte == b'.';
                if let Some(start) = bytes[at..].iter().position(is_digit) {
                    let start = at + start;
                    let end =
                        bytes[start..].iter().position(|b| !is_digit(b)).map_or(bytes.len(), |n| start + n);
                    bytes.splice(start..end, WORDS[dice.below(WORDS.len())].iter().copied());
                }
            }
        }
    }
    bytes
}

/// Makes the checksums of a PNG right again, so that what was damaged is looked at.
fn mend_checksums(bytes: &mut [u8]) {
    let mut at = 8;
    while let Some(head) = bytes.get(at..at + 8) {
        let length = u32::from_be_bytes([head[0], head[1], head[2], head[3]]) as usize;
        let Some(end) = length.checked_add(at + 8).filter(|end| end + 4 <= bytes.len()) else { return };
        let sum = checksum(&bytes[at + 4..end]);
        bytes[end..end + 4].copy_from_slice(&sum.to_be_bytes());
        at = end + 4;
    }
}

fn checksum(bytes: &[u8]) -> u32 {
    let step = |sum: u32, _| if sum & 1 == 1 { (sum >> 1) ^ 0xedb8_8320 } else { sum >> 1 };
    !bytes.iter().fold(!0, |sum, byte| (0..8).fold(sum ^ u32::from(*byte), step))
}

/// The samples, and a folder of their own for the damaged ones.
struct Files {
    samples: PathBuf,
    folder: PathBuf,
}

impl Files {
    fn new() -> Self {
        let samples = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/fuzz");
        // In memory: a disk waits for every file.
        let shared = Path::new("/dev/shm");
        let place = if shared.is_dir() { shared } else { Path::new(env!("CARGO_TARGET_TMPDIR")) };
        let folder = place.join(format!("cylfuse-fuzz-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let files = Self { samples, folder };
        for name in FRAMES.iter().chain(IMAGES.iter().map(|(name, _)| name)) {
            files.restore(name);
        }
        files
    }

    fn sample(&self, name: &str) -> Vec<u8> {
        std::fs::read(self.samples.join(name)).unwrap()
    }

    fn restore(&self, name: &str) {
        std::fs::write(self.folder.join(name), self.sample(name)).unwrap();
    }

    /// Reads one damaged file; whether it could be read.
    fn case(&self, dice: &mut Dice, failures: &mut Vec<&'static str>) -> bool {
        let kind = dice.below(8);
        let (name, frame) = match kind {
            0 | 1 => (FRAMES[kind], FRAMES[kind]),
            2 | 3 => IMAGES[dice.below(IMAGES.len())],
            _ => (CLOUDS[dice.below(CLOUDS.len())], ""),
        };
        let others: &[&str] =
            if frame.is_empty() { &CLOUDS } else { &["depth.png", "colour.jpg", "views.json"] };
        let other = self.sample(others[dice.below(others.len())]);
        let mut bytes = damaged(dice, &self.sample(name), &other);
        if name.ends_with(".png") && !dice.one_in(3) {
            mend_checksums(&mut bytes);
        }
        let path = self.folder.join(name);
        std::fs::write(&path, &bytes).unwrap();
        drop(bytes);
        let before = held();
        reset_most_held();
        let outcome = if frame.is_empty() {
            CloudFile::read(&path).and_then(|cloud| Ok(cloud.view().map(drop)?))
        } else {
            let frame = Frame::read(&self.folder.join(frame), true);
            frame.and_then(|frame| Ok(frame.views.iter().try_for_each(|view| view.observed().map(drop))?))
        };
        let taken = most_held() - before;
        assert!(taken < MOST_MEMORY, "{taken} bytes of memory for a file of kind {name}");
        if !frame.is_empty() {
            self.restore(name);
        }
        let Err(failure) = outcome else { return true };
        let known = OWN_STATUSES.contains(&failure.status) || LIBRARY_STATUSES.contains(&failure.status);
        assert!(known, "{failure:?}");
        assert!(!failure.message.is_empty() && !failure.message.contains('\n'), "{failure:?}");
        failures.push(failure.status);
        false
    }
}

#[test]
fn files() {
    let count = setting("CYLFUSE_FUZZ_FILES").unwrap_or(FILES);
    let files = Files::new();
    let one = setting("CYLFUSE_FUZZ_CASE");
    let first = one.or(setting("CYLFUSE_FUZZ_FIRST")).unwrap_or(0);
    let cases = if one.is_some() { first..first + 1 } else { first..first + count };
    let (mut read, mut failed, mut failures) = (0_u64, Vec::new(), Vec::new());
    for case in cases {
        let before = held();
        let outcome = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| {
            watch::FILES.run(case, || files.case(&mut Dice::new(case), &mut failures))
        }));
        if let Ok(was_read) = outcome {
            read += u64::from(was_read);
            // The list of failures grows now and then.
            let kept = held() - before - 2 * (failures.capacity() * size_of::<&str>()) as isize;
            assert!(kept <= 0 || case < first + 10, "case {case} keeps {kept} bytes");
        } else {
            eprintln!("^ in case {case}");
            failed.push(case);
            FRAMES.iter().chain(IMAGES.iter().map(|(name, _)| name)).for_each(|name| files.restore(name));
        }
        if failed.len() >= 20 {
            break;
        }
    }
    let _ = std::fs::remove_dir_all(&files.folder);
    assert!(failed.is_empty(), "in cases {failed:?}");
    let mut kinds: Vec<_> = OWN_STATUSES.into_iter().chain(LIBRARY_STATUSES).collect();
    kinds.retain(|kind| failures.contains(kind));
    println!("fuzz: {count} files, {read} of them read; the others: {kinds:?}");
    let enough = one.is_some() || count < 10_000 || (read > count / 50 && kinds.len() >= 5);
    assert!(enough, "the files are damaged too much or too little");
}

#[test]
fn samples_are_read() {
    let samples = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/fuzz");
    for name in FRAMES {
        Frame::read(&samples.join(name), true).unwrap_or_else(|failure| panic!("{failure:?}"));
    }
    for name in CLOUDS {
        let cloud = CloudFile::read(&samples.join(name)).unwrap_or_else(|failure| panic!("{failure:?}"));
        assert_eq!(cloud.points.to_f64().len(), 20, "{name}");
    }
}

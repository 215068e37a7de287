//! Changed copies of pipeline files, each a function of seed and number.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use std::ops::Range;
use std::path::{Path, PathBuf};

/// Numbers at the ends of what types and physics can bear, and beyond.
const NUMBERS: &[&str] = &[
    "0",
    "-0.0",
    "1",
    "-1",
    "0.1",
    "1e-320",
    "1e18",
    "1e308",
    "-1e308",
    "1e400",
    "3.5e38",
    "inf",
    "-inf",
    "nan",
    "65536",
    "2147483648",
    "4294967295",
    "4294967296",
    "1_000_000_000_000",
    "9007199254740993",
    "9223372036854775807",
    "-9223372036854775808",
    "9223372036854775808",
    "18446744073709551616",
    "0x7fffffffffffffff",
    "0o777",
    "0b1",
    "1979-05-27T07:32:00Z",
];

/// Pieces that are likely to meet a special case.
const PIECES: &[&str] = &[
    "=",
    "[",
    "]",
    "[[",
    "]]",
    "{",
    "}",
    "{}",
    "[]",
    ",",
    ".",
    "#",
    "\"",
    "'",
    "\"\"\"",
    "'''",
    "\\",
    "\\u0000",
    "\"\\U0010FFFF\"",
    "\r",
    "\t",
    "\n",
    "\u{0}",
    "\u{7f}",
    "\u{85}",
    "\u{feff}",
    "\u{202e}",
    "\u{1F9A0}",
    "e\u{301}\u{301}\u{301}",
    "\u{10ffff}",
    "true",
    "_",
    "\"\" = 1",
    "a.b.c = 1",
    "[[stage]]\nkind = \"apply\"\n",
    "[run]\n",
    "[[output]]\nrecord = [\"particles\"]\n",
    "[[analyzer]]\nkind = \"swim\"\n",
    "walls = { axis = \"y\" }\n",
    "init = { from = \"/dev/null\" }\n",
    "init = { from = \"..\" }\n",
    "init = { from = \"\\u0000\" }\n",
];

/// The files to change.
pub struct Originals {
    files: Vec<(PathBuf, Vec<u8>)>,
    /// Words and numbers of all of them.
    words: Vec<Vec<u8>>,
}

impl Originals {
    /// Every pipeline file in a folder and the folders in it.
    pub fn new(folder: &Path) -> Result<Self, String> {
        let (mut files, mut folders) = (Vec::new(), vec![folder.to_owned()]);
        while let Some(folder) = folders.pop() {
            let failed = |e| format!("{}: {e}", folder.display());
            for entry in std::fs::read_dir(&folder).map_err(failed)? {
                let path = entry.map_err(failed)?.path();
                if path.is_dir() {
                    folders.push(path);
                } else if path.extension().is_some_and(|e| e == "toml") {
                    let bytes = std::fs::read(&path).map_err(|e| format!("{}: {e}", path.display()))?;
                    files.push((path, bytes));
                }
            }
        }
        files.sort();
        if files.is_empty() {
            return Err(format!("there is no pipeline file in {}", folder.display()));
        }
        let all = files.iter().flat_map(|(_, bytes)| tokens(bytes).into_iter().map(|t| bytes[t].to_vec()));
        let mut words: Vec<Vec<u8>> = all.filter(|word| word.len() > 1).collect();
        words.sort_unstable();
        words.dedup();
        Ok(Self { files, words })
    }

    /// How many files there are.
    pub fn len(&self) -> usize {
        self.files.len()
    }

    /// The copy of this number: the path of its original, and its bytes.
    pub fn changed(&self, seed: u64, number: u32) -> (&Path, Vec<u8>) {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        random.set_stream(number.into());
        let (path, bytes) = &self.files[random.random_range(0..self.files.len())];
        let mut bytes = bytes.clone();
        for _ in 0..random.random_range(1..=4) {
            self.change(&mut bytes, &mut random);
        }
        (path, bytes)
    }

    fn change(&self, bytes: &mut Vec<u8>, random: &mut ChaCha8Rng) {
        match random.random_range(0..20) {
            0..3 => of_bytes(bytes, random),
            3..9 => self.of_tokens(bytes, random),
            9..12 => of_parts(bytes, lines(bytes), random),
            12..14 => of_parts(bytes, sections(bytes), random),
            14..17 => of_numbers(bytes, random),
            17..19 => {
                let piece = PIECES[random.random_range(0..PIECES.len())];
                let at = random.random_range(0..=bytes.len());
                bytes.splice(at..at, piece.bytes());
            }
            _ => swollen(bytes, random),
        }
    }

    /// One word or sign: left out, doubled, another's place, another word, another spelling.
    fn of_tokens(&self, bytes: &mut Vec<u8>, random: &mut ChaCha8Rng) {
        let all = tokens(bytes);
        if random.random_bool(0.4) {
            return of_parts(bytes, all, random);
        }
        let Some(token) = pick(&all, random) else { return };
        let mut word = bytes[token.clone()].to_vec();
        let at = random.random_range(0..word.len());
        match random.random_range(0..5) {
            0 => word = self.words[random.random_range(0..self.words.len())].clone(),
            1 => drop(word.remove(at)),
            2 => word.insert(at, word[at]),
            3 => word.make_ascii_uppercase(),
            _ => word[at] = random.random_range(b'a'..=b'z'),
        }
        bytes.splice(token, word);
    }
}

/// Any byte: left out, turned into another, doubled, or the end of the file.
fn of_bytes(bytes: &mut Vec<u8>, random: &mut ChaCha8Rng) {
    if bytes.is_empty() {
        return;
    }
    let at = random.random_range(0..bytes.len());
    let end = (at + random.random_range(1..20)).min(bytes.len());
    match random.random_range(0..6) {
        0 => drop(bytes.drain(at..end)),
        1 => bytes[at] = random.random(),
        2 => bytes[at] ^= 1 << random.random_range(0..8),
        3 => bytes.insert(at, random.random()),
        4 => {
            let part = bytes[at..end].to_vec();
            bytes.splice(at..at, part);
        }
        _ => bytes.truncate(at),
    }
}

/// One of these parts: left out, doubled, moved, or in the place of another.
fn of_parts(bytes: &mut Vec<u8>, parts: Vec<Range<usize>>, random: &mut ChaCha8Rng) {
    let (Some(one), Some(other)) = (pick(&parts, random), pick(&parts, random)) else { return };
    let text = bytes[one.clone()].to_vec();
    match random.random_range(0..4) {
        0 => drop(bytes.drain(one)),
        1 => drop(bytes.splice(one.start..one.start, text)),
        2 if one.end <= other.start => {
            bytes.splice(other.start..other.start, text);
            bytes.drain(one);
        }
        2 => {
            bytes.drain(one.clone());
            let at = if other.start < one.start { other.start } else { one.start };
            bytes.splice(at..at, text);
        }
        _ => drop(bytes.splice(other, text)),
    }
}

/// A number becomes one that nobody would write.
fn of_numbers(bytes: &mut Vec<u8>, random: &mut ChaCha8Rng) {
    let mut all = tokens(bytes);
    all.retain(|token| bytes[token.start].is_ascii_digit());
    if let Some(token) = pick(&all, random) {
        bytes.splice(token, NUMBERS[random.random_range(0..NUMBERS.len())].bytes());
    }
}

/// Something very long or very deep.
fn swollen(bytes: &mut Vec<u8>, random: &mut ChaCha8Rng) {
    let all = tokens(bytes);
    let Some(token) = pick(&all, random) else { return };
    // Most are short of what takes long, so that many can be tried.
    let much = 10_usize.pow(random.random_range(1..=4)) * random.random_range(1..=9);
    let text: Vec<u8> = match random.random_range(0..7) {
        0 => b"[".repeat(much),
        1 => b"{a=".repeat(much),
        2 => b"a.".repeat(much),
        3 => [b"\"".to_vec(), "\u{e9}".repeat(much).into_bytes(), b"\"".to_vec()].concat(),
        4 => [b"[".to_vec(), b"1,".repeat(much), b"]".to_vec()].concat(),
        5 => b"[[squirmers]]\n".repeat(much.min(3000)),
        _ => bytes[token.clone()].repeat(much.min(2000)),
    };
    bytes.splice(token, text);
}

fn pick(parts: &[Range<usize>], random: &mut ChaCha8Rng) -> Option<Range<usize>> {
    (!parts.is_empty()).then(|| parts[random.random_range(0..parts.len())].clone())
}

/// Words, numbers and signs outside of comments.
fn tokens(bytes: &[u8]) -> Vec<Range<usize>> {
    let (mut found, mut at) = (Vec::new(), 0);
    let within = |b: u8| b.is_ascii_alphanumeric() || b"_-.+".contains(&b);
    while at < bytes.len() {
        let start = at;
        at += 1;
        if bytes[start] == b'#' {
            at += bytes[at..].iter().position(|b| *b == b'\n').unwrap_or(bytes.len() - at);
        } else if within(bytes[start]) {
            at += bytes[at..].iter().position(|b| !within(*b)).unwrap_or(bytes.len() - at);
            found.push(start..at);
        } else if !bytes[start].is_ascii_whitespace() {
            found.push(start..at);
        }
    }
    found
}

fn lines(bytes: &[u8]) -> Vec<Range<usize>> {
    starts(bytes, |_| true)
}

/// From one header to the next.
fn sections(bytes: &[u8]) -> Vec<Range<usize>> {
    starts(bytes, |line| line.first() == Some(&b'['))
}

fn starts(bytes: &[u8], begins: impl Fn(&[u8]) -> bool) -> Vec<Range<usize>> {
    let after = bytes.iter().enumerate().filter(|(_, b)| **b == b'\n').map(|(i, _)| i + 1);
    let mut all: Vec<usize> = std::iter::once(0).chain(after).filter(|i| begins(&bytes[*i..])).collect();
    all.push(bytes.len());
    all.windows(2).map(|w| w[0]..w[1]).filter(|part| !part.is_empty()).collect()
}

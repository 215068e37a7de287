//! Arrays larger than what a kernel can bind: several bindings in the place of one, and functions that choose among them.
//!
//! Shaders are written as if every array were one binding. Where a run's array is larger, its declaration becomes one for each part, and
//! what reads, writes or atomically changes an element calls a function that finds the part by the upper bits of the index.

use super::reflect::{Binding, Module, ShaderError};
use std::fmt::Write as _;

/// The name of a part of an array; the only one is the array itself.
fn part_name(name: &str, part: u32) -> String {
    format!("{name}_part{part}")
}

/// An array of a module in parts.
struct Array<'a> {
    name: &'a str,
    /// WGSL type of its elements, as declared.
    element: String,
    parts: u32,
    /// log2 of the elements of a part.
    bits: u32,
}

/// The module with several bindings for each array of which there is more than one part; `parts` tells how many there are of this name. All
/// but the last have `bytes` bytes, a power of two.
///
/// # Errors
/// If such an array is used in a way that this does not know.
pub fn split(module: &Module, parts: impl Fn(&str) -> u32, bytes: u64) -> Result<Module, ShaderError> {
    let mut out = module.clone();
    let mut free = 1 + module.all_bindings().map(|b| b.binding).max().unwrap_or(0);
    let mut names: Vec<&str> = module.all_bindings().map(|b| b.name.as_str()).filter(|name| parts(name) > 1).collect();
    names.sort_unstable();
    names.dedup();
    for name in names {
        let parts = parts(name);
        let (text, array) = declare(&out.text, (name, parts, bytes), free)?;
        let mut atomics = Vec::new();
        let lines = text.lines().map(|line| {
            if line.trim_start().starts_with("//") { Ok(line.to_owned()) } else { array.rewritten(line, &mut atomics) }
        });
        let lines = lines.collect::<Result<Vec<_>, _>>()?;
        out.text = lines.join("\n") + "\n" + &array.functions(&text, &atomics);
        out.extend(name, |of: &Binding| {
            (1..parts).map(|part| Binding { binding: free + part - 1, part, ..of.clone() }).collect()
        });
        free += parts - 1;
    }
    Ok(out)
}

/// The text with a declaration for each part; those after the first are bound from `free` on.
fn declare<'a>(
    text: &str,
    (name, parts, bytes): (&'a str, u32, u64),
    free: u32,
) -> Result<(String, Array<'a>), ShaderError> {
    let unknown = || ShaderError::Whole { name: name.to_owned() };
    let mark = format!("> {name}: array<");
    let line = text.lines().find(|line| line.starts_with("@group(") && line.contains(&mark)).ok_or_else(unknown)?;
    let (head, element) = line.split_once(&mark).ok_or_else(unknown)?;
    let element = element.strip_suffix(">;").ok_or_else(unknown)?.to_owned();
    let words: u64 = match element.trim_start_matches("atomic<").split('<').next() {
        Some("u32" | "i32" | "f32" | "u32>" | "i32>") => 1,
        Some("vec2") => 2,
        Some("vec4") => 4,
        _ => return Err(unknown()),
    };
    let (before, after) = head.split_once("@binding(").ok_or_else(unknown)?;
    let (number, after) = after.split_once(')').ok_or_else(unknown)?;
    let mut lines = String::new();
    for part in 0..parts {
        let number = if part == 0 { number.to_owned() } else { (free + part - 1).to_string() };
        let _ = writeln!(lines, "{before}@binding({number}){after}> {}: array<{element}>;", part_name(name, part));
    }
    let array = Array { name, element, parts, bits: (bytes / (4 * words)).ilog2() };
    Ok((text.replacen(&format!("{line}\n"), &lines, 1), array))
}

/// Whether a character can be inside a name.
fn of_name(c: char) -> bool {
    c.is_alphanumeric() || c == '_'
}

/// Where the bracket ends that begins before `text`.
fn closing(text: &str) -> Option<usize> {
    let mut depth = 1;
    text.char_indices().find_map(|(at, c)| {
        depth += match c {
            '[' => 1,
            ']' => -1,
            _ => 0,
        };
        (depth == 0).then_some(at)
    })
}

impl Array<'_> {
    /// A line with calls in the place of elements; names of the atomic functions among them.
    fn rewritten(&self, line: &str, atomics: &mut Vec<String>) -> Result<String, ShaderError> {
        let unknown = || ShaderError::Whole { name: self.name.to_owned() };
        let (mut line, name) = (line.to_owned(), self.name);
        let mark = format!("{name}[");
        // From the right, so that what is inside an index comes before what it is the index of.
        while let Some(at) = line.rmatch_indices(&mark).map(|(at, _)| at).find(|at| !line[..*at].ends_with(of_name)) {
            let (before, after) = (&line[..at], &line[at + mark.len()..]);
            let end = closing(after).ok_or_else(unknown)?;
            let (index, rest) = (&after[..end], &after[end + 1..]);
            line = if let Some(before) = before.strip_suffix("(&") {
                let begin = before.rfind(|c| !of_name(c)).map_or(0, |k| k + 1);
                let function = &before[begin..];
                if !atomics.iter().any(|known| known == function) {
                    atomics.push(function.to_owned());
                }
                format!("{}{function}_element_of_{name}({index}{rest}", &before[..begin])
            } else if let Some(value) = rest.strip_prefix(" = ") {
                let (value, rest) = value.split_once(';').ok_or_else(unknown)?;
                format!("{before}set_element_of_{name}({index}, {value});{rest}")
            } else {
                format!("{before}element_of_{name}({index}){rest}")
            };
        }
        Ok(line)
    }

    /// A switch over the parts; `use_of` says what is done with the element of one.
    fn choice(&self, use_of: impl Fn(&str) -> String) -> String {
        let mask = (1u64 << self.bits) - 1;
        let mut text = format!("    switch i >> {}u {{\n", self.bits);
        for part in 0..self.parts {
            let case = if part + 1 == self.parts { "default".to_owned() } else { format!("case {part}u") };
            let element = format!("{}[i & {mask}u]", part_name(self.name, part));
            let _ = writeln!(text, "        {case}: {{ {} }}", use_of(&element));
        }
        text + "    }\n"
    }

    /// The functions that are called now.
    fn functions(&self, text: &str, atomics: &[String]) -> String {
        let (name, element) = (self.name, &self.element);
        let mut out = String::new();
        let mut function = |head: String, choice: String| {
            let _ = writeln!(out, "fn {head} {{\n{choice}}}");
        };
        if let Some(inner) = element.strip_prefix("atomic<") {
            let inner = inner.trim_end_matches('>');
            for atomic in atomics {
                let head = format!("{atomic}_element_of_{name}");
                match atomic.as_str() {
                    "atomicLoad" => {
                        function(
                            format!("{head}(i: u32) -> {inner}"),
                            self.choice(|e| format!("return {atomic}(&{e});")),
                        );
                    }
                    "atomicStore" => function(
                        format!("{head}(i: u32, value: {inner})"),
                        self.choice(|e| format!("{atomic}(&{e}, value);")),
                    ),
                    _ => function(
                        format!("{head}(i: u32, value: {inner}) -> {inner}"),
                        self.choice(|e| format!("return {atomic}(&{e}, value);")),
                    ),
                }
            }
            return out;
        }
        let read = self.choice(|e| format!("return {e};"));
        function(format!("element_of_{name}(i: u32) -> {element}"), read);
        if text.contains(&format!("read_write> {}: ", part_name(name, 0))) {
            let written = self.choice(|e| format!("{e} = value;"));
            function(format!("set_element_of_{name}(i: u32, value: {element})"), written);
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "@group(0) @binding(0) var<storage, read_write> particles: array<vec4<u32>>;\n\
        @group(0) @binding(1) var<storage, read_write> moments: array<atomic<u32>>;\n\
        @group(0) @binding(4) var<storage, read> links: array<u32>;\n\
        // particles[0] is a comment\n\
        @compute @workgroup_size(1) fn move_on() {\n\
            particles[links[2u]] = particles[links[links[1]] + 1u];\n\
            if links[3] > 4u { atomicStore(&moments[links[5]], atomicAdd(&moments[6], links[7])); }\n\
        }\n\
        @compute @workgroup_size(1) fn count() { atomicAdd(&moments[0], 1u); }\n";

    fn validated(text: &str) {
        let module = naga::front::wgsl::parse_str(text).unwrap_or_else(|e| panic!("{}", e.emit_to_string(text)));
        naga::valid::Validator::new(naga::valid::ValidationFlags::all(), naga::valid::Capabilities::all())
            .validate(&module)
            .unwrap_or_else(|e| panic!("{}", e.emit_to_string(text)));
    }

    #[test]
    fn elements_of_arrays_in_parts_are_found_by_functions() {
        let module = Module::new("test", TEXT, "").expect("valid");
        let parts = |name: &str| match name {
            "particles" => 3,
            "links" => 2,
            _ => 1,
        };
        let apart = split(&module, parts, 64).expect("known uses");
        validated(&apart.text);
        for line in [
            "set_element_of_particles(element_of_links(2u), element_of_particles(element_of_links(element_of_links(1)) + 1u));",
            "if element_of_links(3) > 4u { atomicStore(&moments[element_of_links(5)], atomicAdd(&moments[6], element_of_links(7))); }",
            "// particles[0] is a comment",
            "@group(0) @binding(0) var<storage, read_write> particles_part0: array<vec4<u32>>;",
            "case 1u: { return particles_part1[i & 3u]; }",
            "default: { particles_part2[i & 3u] = value; }",
            "switch i >> 4u {",
        ] {
            assert!(apart.text.contains(line), "{line}\n{}", apart.text);
        }
        // Every part has a binding of its own; the others keep theirs.
        let numbers = |entry: &str| {
            let all = apart.bindings(entry).iter().map(|b| (b.name.clone(), b.part, b.binding));
            all.collect::<Vec<_>>()
        };
        let named =
            |list: &[(&str, u32, u32)]| list.iter().map(|(n, p, b)| ((*n).to_owned(), *p, *b)).collect::<Vec<_>>();
        let all = [
            ("particles", 0, 0),
            ("moments", 0, 1),
            ("links", 0, 4),
            ("links", 1, 5),
            ("particles", 1, 6),
            ("particles", 2, 7),
        ];
        assert_eq!(numbers("move_on"), named(&all));
        assert_eq!(numbers("count"), named(&[("moments", 0, 1)]));
    }

    #[test]
    fn atomics_of_arrays_in_parts_are_functions() {
        let module = Module::new("test", TEXT, "").expect("valid");
        let apart = split(&module, |name| if name == "moments" { 2 } else { 1 }, 1 << 20).expect("known uses");
        validated(&apart.text);
        for line in [
            "atomicStore_element_of_moments(links[5], atomicAdd_element_of_moments(6, links[7]));",
            "fn atomicAdd_element_of_moments(i: u32, value: u32) -> u32 {",
            "case 0u: { atomicStore(&moments_part0[i & 262143u], value); }",
        ] {
            assert!(apart.text.contains(line), "{line}\n{}", apart.text);
        }
    }

    #[test]
    fn what_is_whole_stays_as_it_is() {
        let module = Module::new("test", TEXT, "").expect("valid");
        let same = split(&module, |_| 1, 64).expect("nothing to do");
        assert_eq!(same.text, module.text);
        assert_eq!(same.bindings("move_on"), module.bindings("move_on"));
    }

    #[test]
    fn arrays_of_structs_are_not_split() {
        let text = "@group(0) @binding(0) var<storage, read> squirmers: array<SquirmerState>;\n\
            @compute @workgroup_size(1) fn f() { _ = squirmers[0].species; }\n";
        let module = Module::new("test", text, "").expect("valid");
        assert!(matches!(split(&module, |_| 2, 64), Err(ShaderError::Whole { name }) if name == "squirmers"));
    }
}

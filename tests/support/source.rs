//! Reads Rust as far as the walls need it: words without comments, text and tests; and the paths and
//! macros that stand in them, by their full names whatever they are imported as.
//!
//! Out of scope: types, macros' expansions, conditions other than `test`.

use std::collections::{BTreeMap, BTreeSet};

/// A piece of a program.
#[derive(Clone, Debug, PartialEq, Eq)]
enum Token {
    Word(String),
    Number(String),
    Sign(char),
    /// Text, a character or a lifetime: what is in it is no code.
    Quoted(String),
}

impl Token {
    fn is_sign(&self, sign: char) -> bool {
        *self == Self::Sign(sign)
    }

    fn is_word(&self, word: &str) -> bool {
        matches!(self, Self::Word(w) if w == word)
    }
}

/// What the code of a file says, its tests left out.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Source {
    /// Every path that stands in it, full: `use std::{fs as disk}; disk::read` is `std::fs` and
    /// `std::fs::read`. A glob ends in `*`.
    pub(crate) paths: BTreeSet<Vec<String>>,
    /// Macros that are called, by their last name.
    pub(crate) macros: BTreeSet<String>,
    /// Endings of numbers, as in `1.0f32`.
    pub(crate) suffixes: BTreeSet<String>,
    /// Modules in files of their own, and whether each is there for tests only.
    pub(crate) modules: BTreeMap<String, bool>,
    /// Whether it takes in code from elsewhere, which the walls would not see.
    pub(crate) takes_in_files: bool,
}

impl Source {
    /// Reads a file.
    pub(crate) fn read(text: &str) -> Self {
        let (tokens, test_modules) = without_tests(&tokens(text));
        let mut out = Self::default();
        out.modules
            .extend(test_modules.into_iter().map(|name| (name, true)));
        let mut aliases: BTreeMap<String, Vec<Vec<String>>> = BTreeMap::new();
        let mut written = BTreeSet::new();
        let mut at = 0;
        while at < tokens.len() {
            let after = |n: usize| tokens.get(at + n);
            match &tokens[at] {
                Token::Number(number) => {
                    for suffix in ["f32", "f64"] {
                        if number.ends_with(suffix) {
                            out.suffixes.insert(suffix.to_owned());
                        }
                    }
                }
                Token::Word(word) if word == "use" && !after(1).is_some_and(|t| t.is_sign('<')) => {
                    at = import(&tokens, at + 1, &[], &mut |path, name| {
                        if name != path[path.len() - 1] || path.len() > 1 {
                            aliases.entry(name).or_default().push(path.clone());
                        }
                        written.insert(path);
                    });
                    continue;
                }
                Token::Word(word)
                    if word == "extern" && after(1).is_some_and(|t| t.is_word("crate")) =>
                {
                    at = import(&tokens, at + 2, &[], &mut |path, name| {
                        if name != path[0] {
                            aliases.entry(name).or_default().push(path.clone());
                        }
                        written.insert(path);
                    });
                    continue;
                }
                Token::Word(word) if word == "mod" => {
                    if let (Some(Token::Word(name)), Some(true)) =
                        (after(1), after(2).map(|t| t.is_sign(';')))
                    {
                        out.modules.insert(name.clone(), false);
                    }
                    // to hold a module is not to know it
                    at += 2;
                    continue;
                }
                Token::Word(_) if at == 0 || !tokens[at - 1].is_sign('.') => {
                    let (path, end) = path_at(&tokens, at);
                    let called = tokens.get(end).is_some_and(|t| t.is_sign('!'))
                        && !tokens.get(end + 1).is_some_and(|t| t.is_sign('='));
                    if called {
                        out.macros.insert(path[path.len() - 1].clone());
                    }
                    written.insert(path);
                    at = end;
                    continue;
                }
                Token::Sign('#') => {
                    let (attribute, _) = attribute_at(&tokens, at);
                    out.takes_in_files |= attribute.first().is_some_and(|t| t.is_word("path"));
                }
                _ => {}
            }
            at += 1;
        }
        out.takes_in_files |= out.macros.contains("include");
        out.paths = full(written, &aliases);
        out
    }

    /// Whether a form stands in the code: a path or a part of one (`std::fs`), a macro (`println!`), a
    /// word (`f32`).
    pub(crate) fn uses(&self, form: &str) -> bool {
        if let Some(name) = form.strip_suffix('!') {
            let under_another_name = vec!["std".to_owned(), name.to_owned()];
            return self.macros.contains(name) || self.paths.contains(&under_another_name);
        }
        let form: Vec<&str> = form.split("::").collect();
        let stands_in = |path: &Vec<String>| {
            if path.windows(form.len()).any(|part| part == form.as_slice()) {
                return true;
            }
            // a glob takes in what is below it
            let above = path.split_last().filter(|(last, _)| *last == "*");
            above
                .is_some_and(|(_, above)| above.len() < form.len() && form[..above.len()] == *above)
        };
        self.paths.iter().any(stands_in) || (form.len() == 1 && self.suffixes.contains(form[0]))
    }
}

/// Paths as written, and what they stand for.
fn full(
    written: BTreeSet<Vec<String>>,
    aliases: &BTreeMap<String, Vec<Vec<String>>>,
) -> BTreeSet<Vec<String>> {
    let mut out = BTreeSet::new();
    let mut open: Vec<Vec<String>> = written.into_iter().collect();
    while let Some(path) = open.pop() {
        for meant in aliases.get(&path[0]).into_iter().flatten() {
            let whole: Vec<String> = meant.iter().chain(&path[1..]).cloned().collect();
            // a name that stands for a path beginning with itself would go on for ever
            if meant[0] != path[0] && !out.contains(&whole) {
                open.push(whole);
            } else {
                out.insert(whole);
            }
        }
        out.insert(path);
    }
    out
}

/// A path that begins at a word, and where it ends.
fn path_at(tokens: &[Token], mut at: usize) -> (Vec<String>, usize) {
    let mut path = Vec::new();
    while let Some(Token::Word(word)) = tokens.get(at) {
        path.push(word.clone());
        at += 1;
        let joined = tokens
            .get(at..at + 2)
            .is_some_and(|pair| pair.iter().all(|t| t.is_sign(':')));
        if !joined || !matches!(tokens.get(at + 2), Some(Token::Word(_))) {
            break;
        }
        at += 2;
    }
    (path, at)
}

/// The tree of an import from `at` on; tells each path and the name it is known by, and where the tree
/// ends.
fn import(
    tokens: &[Token],
    mut at: usize,
    before: &[String],
    found: &mut impl FnMut(Vec<String>, String),
) -> usize {
    let mut path = before.to_vec();
    loop {
        match tokens.get(at) {
            Some(Token::Sign(':')) => at += 1,
            Some(Token::Sign('{')) => {
                at += 1;
                while tokens.get(at).is_some_and(|t| !t.is_sign('}')) {
                    let next = import(tokens, at, &path, found);
                    at = next + usize::from(tokens.get(next).is_some_and(|t| t.is_sign(',')));
                    assert!(
                        at > next || tokens.get(at).is_some_and(|t| t.is_sign('}')),
                        "a tree"
                    );
                }
                return at + 1;
            }
            Some(Token::Sign('*')) => {
                path.push("*".to_owned());
                found(path, "*".to_owned());
                return at + 1;
            }
            Some(Token::Word(word)) if word == "as" => {
                if let Some(Token::Word(name)) = tokens.get(at + 1) {
                    found(path, name.clone());
                }
                return at + 2;
            }
            Some(Token::Word(word)) => {
                if word != "self" || path.is_empty() {
                    path.push(word.clone());
                }
                at += 1;
            }
            _ => {
                if let Some(name) = path.last().cloned() {
                    found(path, name);
                }
                return at;
            }
        }
    }
}

/// What stands in an attribute that begins at `#`, and where it ends; nothing where none begins.
fn attribute_at(tokens: &[Token], at: usize) -> (&[Token], usize) {
    let open = at + 1 + usize::from(tokens.get(at + 1).is_some_and(|t| t.is_sign('!')));
    if !tokens.get(open).is_some_and(|t| t.is_sign('[')) {
        return (&[], at + 1);
    }
    let end = group_end(tokens, open);
    (&tokens[open + 1..end - 1], end)
}

/// Where the group that opens at `at` ends: the place after its last sign.
fn group_end(tokens: &[Token], at: usize) -> usize {
    let mut depth = 0_usize;
    for (i, token) in tokens.iter().enumerate().skip(at) {
        match token {
            Token::Sign('(' | '[' | '{') => depth += 1,
            Token::Sign(')' | ']' | '}') => {
                depth -= 1;
                if depth == 0 {
                    return i + 1;
                }
            }
            _ => {}
        }
    }
    panic!("a group is not closed");
}

/// Whether a condition holds in tests only.
fn only_in_tests(condition: &[Token]) -> bool {
    let Some((Token::Word(word), rest)) = condition.split_first() else {
        return false;
    };
    let inside = rest.get(1..rest.len().saturating_sub(1)).unwrap_or(&[]);
    let mut parts = Vec::new();
    let (mut start, mut depth) = (0, 0_usize);
    for (i, token) in inside.iter().enumerate() {
        match token {
            Token::Sign('(') => depth += 1,
            Token::Sign(')') => depth -= 1,
            Token::Sign(',') if depth == 0 => {
                parts.push(&inside[start..i]);
                start = i + 1;
            }
            _ => {}
        }
    }
    parts.push(&inside[start..]);
    parts.retain(|part| !part.is_empty());
    match word.as_str() {
        "test" => rest.is_empty(),
        "cfg" | "all" => parts.iter().any(|part| only_in_tests(part)),
        "any" => !parts.is_empty() && parts.iter().all(|part| only_in_tests(part)),
        _ => false,
    }
}

/// Where the item that begins at `at` ends.
fn item_end(tokens: &[Token], mut at: usize) -> usize {
    // these end with a semicolon, whatever braces they have
    let ends_with_sign = tokens[at..]
        .iter()
        .take_while(|t| matches!(t, Token::Word(_)))
        .find(|t| !t.is_word("pub"))
        .is_some_and(|t| {
            ["use", "static", "let", "type"]
                .iter()
                .any(|w| t.is_word(w))
        });
    while at < tokens.len() {
        match tokens[at] {
            Token::Sign(';') => return at + 1,
            // the end of what the item stands in
            Token::Sign(')' | ']' | '}') => return at,
            Token::Sign('{') => {
                at = group_end(tokens, at);
                if !ends_with_sign {
                    return at;
                }
            }
            Token::Sign('(' | '[') => at = group_end(tokens, at),
            _ => at += 1,
        }
    }
    at
}

/// The code without its tests, and the names of modules in files of their own that are tests.
fn without_tests(tokens: &[Token]) -> (Vec<Token>, Vec<String>) {
    let (mut out, mut modules) = (Vec::new(), Vec::new());
    let mut at = 0;
    while at < tokens.len() {
        if !tokens[at].is_sign('#') {
            out.push(tokens[at].clone());
            at += 1;
            continue;
        }
        let (attribute, mut end) = attribute_at(tokens, at);
        if !only_in_tests(attribute) {
            out.extend_from_slice(&tokens[at..end]);
            at = end;
            continue;
        }
        if tokens[at + 1].is_sign('!') {
            // of the file, or of the block it stands in
            return (Vec::new(), modules);
        }
        while tokens.get(end).is_some_and(|t| t.is_sign('#')) {
            end = attribute_at(tokens, end).1;
        }
        at = item_end(tokens, end);
        let item = &tokens[end..at];
        if let Some([.., Token::Word(word), Token::Word(name)]) = item.split_last().map(|(_, i)| i)
            && word == "mod"
        {
            modules.push(name.clone());
        }
    }
    (out, modules)
}

/// Where text that begins with `#`s or a quote after a prefix ends; `None` if none begins here.
fn raw_text_end(text: &[char], mut at: usize) -> Option<usize> {
    let mut hashes = 0;
    while text.get(at) == Some(&'#') {
        hashes += 1;
        at += 1;
    }
    if text.get(at) != Some(&'"') {
        return None;
    }
    let closing: Vec<char> = std::iter::once('"')
        .chain(std::iter::repeat_n('#', hashes))
        .collect();
    let length = text[at + 1..]
        .windows(closing.len())
        .position(|w| w == closing)?;
    Some(at + 1 + length + closing.len())
}

/// Where text in quotes that begins at `at` ends.
fn text_end(text: &[char], at: usize) -> usize {
    let quote = text[at];
    let mut i = at + 1;
    while i < text.len() && text[i] != quote {
        i += 1 + usize::from(text[i] == '\\');
    }
    i + 1
}

fn tokens(text: &str) -> Vec<Token> {
    let text: Vec<char> = text.chars().collect();
    let is_word = |c: &char| c.is_alphanumeric() || *c == '_';
    let word_end = |at: usize| at + text[at..].iter().take_while(|c| is_word(c)).count();
    let quoted = |from: usize, to: usize| {
        let end = to.min(text.len());
        Token::Quoted(text[from..end].iter().collect())
    };
    let mut out = Vec::new();
    let mut at = 0;
    while at < text.len() {
        let next = text.get(at + 1).copied();
        match (text[at], next) {
            ('/', Some('/')) => {
                at += text[at..].iter().take_while(|c| **c != '\n').count();
            }
            ('/', Some('*')) => at = comment_end(&text, at),
            ('"', _) => {
                let end = text_end(&text, at);
                out.push(quoted(at, end));
                at = end;
            }
            ('\'', Some(next)) => {
                let is_character = next == '\\' || text.get(at + 2) == Some(&'\'');
                let end = if is_character {
                    text_end(&text, at)
                } else {
                    word_end(at + 1)
                };
                out.push(quoted(at, end));
                at = end;
            }
            (c, _) if c.is_ascii_digit() => {
                let mut end = word_end(at);
                let digit_after = |i: usize| text.get(i + 1).is_some_and(char::is_ascii_digit);
                if text.get(end) == Some(&'.') && digit_after(end) {
                    end = word_end(end + 1);
                }
                out.push(Token::Number(text[at..end].iter().collect()));
                at = end;
            }
            (c, _) if is_word(&c) => {
                let end = word_end(at);
                let word: String = text[at..end].iter().collect();
                let after = text.get(end).copied();
                if ["r", "br", "cr"].contains(&word.as_str())
                    && let Some(end) = raw_text_end(&text, end)
                {
                    out.push(quoted(at, end));
                    at = end;
                } else if word == "r" && after == Some('#') {
                    // a word that would be a keyword
                    at = end + 1;
                } else if (["b", "c"].contains(&word.as_str()) && after == Some('"'))
                    || (word == "b" && after == Some('\''))
                {
                    // the text comes next
                    at = end;
                } else {
                    out.push(Token::Word(word));
                    at = end;
                }
            }
            (c, _) => {
                if !c.is_whitespace() {
                    out.push(Token::Sign(c));
                }
                at += 1;
            }
        }
    }
    out
}

/// Where a comment that may hold others ends.
fn comment_end(text: &[char], mut at: usize) -> usize {
    let mut depth = 0_usize;
    while at < text.len() {
        match (text[at], text.get(at + 1)) {
            ('/', Some('*')) => {
                depth += 1;
                at += 2;
            }
            ('*', Some('/')) => {
                depth -= 1;
                at += 2;
                if depth == 0 {
                    break;
                }
            }
            _ => at += 1,
        }
    }
    at
}

fn uses(text: &str, form: &str) -> bool {
    Source::read(text).uses(form)
}

#[test]
fn every_way_to_name_a_module_is_seen() {
    for text in [
        "use std::fs;",
        "use std::fs::File;",
        "use ::std::fs;",
        "use std::{fs, io};",
        "use std::{collections::{BTreeMap, BTreeSet}, fs::{self, File}};",
        "use {core::fmt, std::fs};",
        "use std::{self as s}; fn f() { s::fs::read(\"x\") }",
        "use std as s; fn f() { s::fs::read(\"x\") }",
        "use std as s; use s as t; use t::fs as disk;",
        "extern crate std as s; fn f() { s::fs::read(\"x\") }",
        "use std::*; fn f() { fs::read(\"x\") }",
        "pub(crate) use std::fs as disk;",
        "fn f() { std::fs::read(\"x\"); }",
        "fn f() { ::std :: fs\n::read(\"x\"); }",
        "fn f() { <std::fs::File as Read>::read() }",
        "fn f() { use std::fs; }",
        "fn f<'a>(x: &'a str) -> char { std::fs::read(x); 'a' }",
        "const A: char = '\"'; use std::fs; const B: char = '\"';",
        "const A: &str = r#\"\"#; use std::fs;",
        "const A: &[u8] = b\"\\\"\"; use std::fs;",
        "const A: char = '\\''; use std::fs;",
        "/* /* */ */ use std::fs;",
        "use r#std::r#fs;",
        "macro_rules! m { () => { std::fs::read(\"x\") } }",
    ] {
        assert!(uses(text, "std::fs"), "{text}");
    }
}

#[test]
fn what_is_no_code_is_not_seen() {
    for text in [
        "// use std::fs;",
        "/* use std::fs; /* */ std::fs */",
        "/// `std::fs`\nfn f() {}",
        "#![doc = \"std::fs\"]",
        "const A: &str = \"use std::fs;\";",
        "const A: &str = r##\"\"# use std::fs; \"##;",
        "use std::fmt; use crate::fs;",
        "use std::{fmt, f64};",
        "#[cfg(test)] mod tests { use std::fs; }",
        "#[cfg(test)]\n#[expect(x, reason = \"}\")]\npub(crate) mod t { fn f() { std::fs::read(\"{\") } }",
        "#[cfg(test)] use std::{fs, io};",
        "#[cfg(all(test, unix))] fn f() { std::fs::read(\"x\") }",
        "#[test] fn f() { std::fs::read(\"x\") }",
        "#![cfg(test)] use std::fs;",
    ] {
        assert!(!uses(text, "std::fs"), "{text}");
    }
}

#[test]
fn what_follows_a_test_is_seen() {
    // The walls once ended at the first test of a file.
    for before in [
        "#[cfg(test)] mod shader_check;",
        "#[cfg(test)] mod tests { fn f() { if true { } } }",
        "#[cfg(test)] use std::{fmt, io};",
        "#[cfg(test)] const A: [u8; 2] = [0; 2];",
        "#[cfg(test)] static A: &str = { \"x\" };",
        "#[cfg(test)] #[derive(Debug)] struct S { a: u8 }",
        "#[cfg(test)] impl S { fn f(&self) {} }",
        "#[test] fn f() {}",
        "struct S { #[cfg(test)] a: u8 }",
    ] {
        let text = format!("{before}\nuse std::fs;");
        assert!(uses(&text, "std::fs"), "{text}");
    }
    for condition in ["not(test)", "any(test, unix)", "feature = \"test\"", "unix"] {
        let text = format!("#[cfg({condition})] mod m {{ use std::fs; }}");
        assert!(uses(&text, "std::fs"), "{text}");
    }
    let source = Source::read("#[cfg(test)] mod check;\nmod air;\npub mod inline {}");
    let modules = BTreeMap::from([("check".to_owned(), true), ("air".to_owned(), false)]);
    assert_eq!(source.modules, modules);
}

#[test]
fn macros_words_and_endings_are_told_apart() {
    assert!(uses("fn f() { println!(\"x\") }", "println!"));
    assert!(uses("fn f() { std::println!(\"x\") }", "println!"));
    assert!(uses(
        "use std::println as say; fn f() { say!(\"x\") }",
        "println!"
    ));
    assert!(!uses("fn f() { eprintln!(\"x\") }", "println!"));
    assert!(!uses(
        "fn f(println: bool) -> bool { println != true }",
        "println!"
    ));
    assert!(uses("fn f(x: f32) {}", "f32"));
    assert!(uses("const A: f64 = 1.0f32 as f64;", "f32"));
    assert!(uses("const A: u8 = 1_f32 as u8;", "f32"));
    assert!(uses("fn f() { core::f32::consts::PI }", "f32"));
    assert!(!uses("fn f(f32x4: u8) {}", "f32"));
    assert!(uses("fn f() { Instant::now() }", "Instant::now"));
    assert!(uses("use rayon::prelude::*;", "rayon"));
    assert!(!uses("use crayon::x;", "rayon"));
    assert!(Source::read("#[path = \"x.rs\"] mod y;").takes_in_files);
    assert!(Source::read("include!(\"x.rs\");").takes_in_files);
    assert!(!Source::read("const A: &str = include_str!(\"x\");").takes_in_files);
}

//! The page that shows how pictures differ: one HTML file that asks for nothing from elsewhere.

use super::Verdict;
use std::fmt::Write as _;
use std::io::{self, Write};

/// A picture of the page.
#[derive(Clone, Copy, Debug)]
pub enum Shown<'a> {
    /// PNG bytes, put into the page itself.
    Embedded(&'a [u8]),
    /// A file beside the page, by its path relative to it with `/` between folders.
    Linked(&'a str),
}

/// The pictures of one entry, as far as there are any.
#[derive(Clone, Copy, Debug, Default)]
pub struct Pictures<'a> {
    /// What is expected.
    pub golden: Option<Shown<'a>>,
    /// What was found.
    pub new: Option<Shown<'a>>,
    /// Where they differ.
    pub difference: Option<Shown<'a>>,
}

/// A page being written, entry by entry, so that no more than one entry's pictures are held.
pub struct Page<'a> {
    out: &'a mut dyn Write,
}

impl std::fmt::Debug for Page<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("Page")
    }
}

const POLICY: &str = "default-src 'none'; img-src data: file: 'self'; style-src 'unsafe-inline'; script-src 'unsafe-inline'";

const CONTROLS: &str = "<button data-view=side>Side by side</button><button data-view=blink>Blink</button>\
<button data-view=slider>Slider</button><button data-view=difference>Difference</button><span class=gap></span>\
<button data-zoom=fit>Fit</button><button data-zoom=1>1×</button><button data-zoom=2>2×</button><button data-zoom=4>4×</button>\
<button data-zoom=8>8×</button>";

const HELP: &str = "<details><summary>Keys and colours</summary><p>1 side by side, 2 blink, 3 slider, 4 difference; z next size; \
j and k next and previous picture.<p>In the difference picture violet pixels differ by less than can be seen; red, orange, yellow and \
white ones by more and more.</details>";

impl<'a> Page<'a> {
    /// Begins a page; `summary` stands under the title.
    ///
    /// # Errors
    /// Those of `out`.
    pub fn begin(out: &'a mut dyn Write, title: &str, summary: &str) -> io::Result<Self> {
        let (title, summary) = (escaped(title), escaped(summary));
        write!(
            out,
            "<!doctype html>\n<html lang=en><meta charset=utf-8><meta name=viewport content=\"width=device-width\">\
             <meta http-equiv=Content-Security-Policy content=\"{POLICY}\"><title>{title}</title>\n<style>{}</style>\n\
             <body data-view=side data-zoom=fit>\n<header><h1>{title}</h1><p>{summary}</p>{CONTROLS}</header>\n<main>\n",
            include_str!("page.css")
        )?;
        Ok(Self { out })
    }

    /// An entry: a name, what was found, the figures in lines, and pictures.
    ///
    /// # Errors
    /// Those of the output.
    pub fn entry(
        &mut self,
        name: &str,
        verdict: &Verdict,
        figures: &str,
        pictures: Pictures<'_>,
    ) -> io::Result<()> {
        self.entry_of(name, verdict.class(), verdict.word(), figures, pictures)
    }

    /// The same by the class and the words of a verdict.
    pub(super) fn entry_of(
        &mut self,
        name: &str,
        class: &str,
        word: &str,
        figures: &str,
        pictures: Pictures<'_>,
    ) -> io::Result<()> {
        let (name, figures) = (escaped(name), escaped(figures));
        write!(
            self.out,
            "<section tabindex=-1 id=\"{name}\"><h2>{name}<span class=\"word {class}\">{word}</span></h2>\n<pre>{figures}</pre>\n"
        )?;
        let paired = pictures.golden.is_some() && pictures.new.is_some();
        if paired {
            self.out.write_all(
                b"<input type=range min=0 max=100 step=any value=50 aria-label=\"golden to the left, new to the right\">\n",
            )?;
        }
        let class = if paired { "set pair" } else { "set" };
        writeln!(self.out, "<div class=\"{class}\">")?;
        for (class, caption, shown) in [
            ("golden", "golden", pictures.golden),
            ("new", "new", pictures.new),
            ("difference", "difference", pictures.difference),
        ] {
            let Some(shown) = shown else { continue };
            write!(
                self.out,
                "<figure class={class}><img alt=\"{caption} of {name}\" src=\""
            )?;
            match shown {
                Shown::Embedded(bytes) => {
                    self.out.write_all(b"data:image/png;base64,")?;
                    base64(bytes, self.out)?;
                }
                Shown::Linked(path) => self.out.write_all(percent(path).as_bytes())?,
            }
            writeln!(self.out, "\"><figcaption>{caption}</figcaption></figure>")?;
        }
        self.out.write_all(b"</div></section>\n")
    }

    /// Ends the page with a list of names that need no pictures.
    ///
    /// # Errors
    /// Those of the output.
    pub fn end(self, others: &str, names: &[String]) -> io::Result<()> {
        if !names.is_empty() {
            let names: Vec<String> = names.iter().map(|n| escaped(n)).collect();
            writeln!(
                self.out,
                "<details><summary>{} {}</summary><pre>{}</pre></details>",
                names.len(),
                escaped(others),
                names.join("\n")
            )?;
        }
        write!(
            self.out,
            "{HELP}</main>\n<script>{}</script>\n",
            include_str!("page.js")
        )
    }
}

/// Text for HTML, in quotes too.
fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\n' => out.push('\n'),
            c if c.is_control() => out.push('\u{fffd}'),
            c => out.push(c),
        }
    }
    out
}

/// A relative path as an address.
fn percent(path: &str) -> String {
    let mut out = String::new();
    for b in path.bytes() {
        if b.is_ascii_alphanumeric() || b"._-/".contains(&b) {
            out.push(b as char);
        } else {
            let _ = write!(out, "%{b:02X}");
        }
    }
    out
}

/// Base 64 with padding (RFC 4648).
fn base64(bytes: &[u8], out: &mut dyn Write) -> io::Result<()> {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = Vec::with_capacity(4096);
    for chunk in bytes.chunks(3 * 1024) {
        text.clear();
        for group in chunk.chunks(3) {
            let mut three = [0; 3];
            three[..group.len()].copy_from_slice(group);
            let n = u32::from_be_bytes([0, three[0], three[1], three[2]]);
            for k in 0..4 {
                let digit = DIGITS[(n >> (18 - 6 * k)) as usize & 63];
                text.push(if k > group.len() { b'=' } else { digit });
            }
        }
        out.write_all(&text)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base64_is_as_the_standard_has_it() {
        for (text, want) in [
            ("", ""),
            ("f", "Zg=="),
            ("fo", "Zm8="),
            ("foo", "Zm9v"),
            ("foob", "Zm9vYg=="),
            ("fooba", "Zm9vYmE="),
            ("foobar", "Zm9vYmFy"),
        ] {
            let mut out = Vec::new();
            base64(text.as_bytes(), &mut out).unwrap();
            assert_eq!(out, want.as_bytes());
        }
        let mut out = Vec::new();
        base64(&[0xfb; 5000], &mut out).unwrap();
        assert_eq!(out.len(), 4 * 5000_usize.div_ceil(3));
    }

    #[test]
    fn names_are_text_and_nothing_else() {
        let mut bytes = Vec::new();
        let mut page = Page::begin(&mut bytes, "<t>", "a & b").unwrap();
        let pictures = Pictures {
            new: Some(Shown::Linked("a b/\"c\".png")),
            ..Pictures::default()
        };
        page.entry("\"><script>x", &Verdict::New, "1 < 2", pictures)
            .unwrap();
        page.end("equal", &["<b>".into()]).unwrap();
        let text = String::from_utf8(bytes).unwrap();
        assert!(!text.contains("<script>x") && !text.contains("<t>") && !text.contains("<b>"));
        assert!(text.contains("src=\"a%20b/%22c%22.png\"") && text.contains("1 &lt; 2"));
        for outside in ["http:", "https:", "url(", "@import", "//cdn"] {
            assert!(!text.contains(outside), "{outside}");
        }
    }
}

//! The keys: one table, of which the help sheet on the screen and the documentation are made.

/// A key as the window sees it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Press {
    /// What the key writes; letters are small.
    Char(char),
    /// The same with a shift key held: letters only, other characters change with it.
    Shift(char),
    /// Arrow.
    Left,
    /// Arrow.
    Right,
    /// Arrow.
    Up,
    /// The large one, or that of the number pad.
    Enter,
    /// Escape.
    Escape,
    /// Function keys, 1 to 12.
    F(u8),
}

/// What a key does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Action {
    /// Uniform level, 0 to 9.
    Level(u32),
    /// One level more or less.
    Levels(i32),
    /// Adaptive tessellation or a uniform level.
    Adaptive,
    /// Half the distance that adaptive triangles may have from the surface, or twice.
    Flatness(i32),
    /// The next of a flag's values, or the one before.
    Next(Cycle, i32),
    /// The limit surface, or the control points of a level.
    LimitOrRefined,
    /// Draws lines of `--overlay` over the picture, or no more.
    Overlay(&'static str),
    /// Turns the lights by so many degrees.
    Light(i32),
    /// Perspective or parallel projection.
    Ortho,
    /// Azimuth and elevation in degrees.
    LookFrom(i32, i32),
    /// The camera as it was at the beginning.
    Reset,
    /// The model turns by itself, or stops.
    Turntable,
    /// Dark or light window behind the model.
    Backdrop,
    /// So many models on.
    Model(i32),
    /// Reads the files again.
    Reload,
    /// Writes the picture.
    Save,
    /// Prints the command line of the picture.
    Print,
    /// Shows or hides the sheet of keys.
    Help,
    /// None, some or all figures.
    Figures,
    /// Ends the program.
    Quit,
}

/// A flag with a list of values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Cycle {
    /// `--shade`
    Shade,
    /// `--surface`
    Surface,
    /// `--scheme`
    Scheme,
}

impl Cycle {
    /// Name of the flag, and its values; the first is the default.
    #[must_use]
    pub(super) fn values(self) -> (&'static str, &'static [&'static str]) {
        match self {
            Self::Shade => (
                "shade",
                &[
                    "lit",
                    "flat",
                    "normals",
                    "uv",
                    "depth",
                    "level",
                    "wireframe",
                ],
            ),
            Self::Surface => ("surface", &["limit", "refined", "cage", "qas", "pn"]),
            Self::Scheme => (
                "scheme",
                &[
                    "auto",
                    "catmull-clark",
                    "loop",
                    "butterfly",
                    "kobbelt",
                    "bilinear",
                ],
            ),
        }
    }
}

/// A line of the sheet.
#[derive(Clone, Copy, Debug)]
pub(super) struct Row {
    /// The keys as the sheet shows them.
    pub(super) keys: &'static str,
    /// What they do.
    pub(super) does: &'static str,
    /// Each key with its action; none for what the mouse does.
    pub(super) presses: &'static [(Press, Action)],
}

const fn row(keys: &'static str, does: &'static str, presses: &'static [(Press, Action)]) -> Row {
    Row {
        keys,
        does,
        presses,
    }
}

use Action::{
    Adaptive, Backdrop, Figures, Flatness, Help, Level, Levels, Light, LimitOrRefined, LookFrom,
    Model, Next, Ortho, Overlay, Print, Quit, Reload, Reset, Save, Turntable,
};
use Press::{Char, Enter, Escape, F, Left, Right, Shift, Up};

/// All there is, by heading.
pub(super) const TABLE: &[(&str, &[Row])] = &[
    (
        "View",
        &[
            row("left drag", "orbit; wheel across turns too", &[]),
            row("middle or Shift+left drag", "pan", &[]),
            row("wheel", "zoom at the pointer", &[]),
            row("right or Ctrl+left drag", "turn the light", &[]),
            row(
                "[ ]",
                "turn the light by 15 degrees",
                &[(Char('['), Light(-15)), (Char(']'), Light(15))],
            ),
            row(
                "F5 F6 F7 F8",
                "front, right, top, three-quarter",
                &[
                    (F(5), LookFrom(0, 0)),
                    (F(6), LookFrom(90, 0)),
                    (F(7), LookFrom(0, 90)),
                    (F(8), LookFrom(45, 25)),
                ],
            ),
            row("O", "parallel projection", &[(Char('o'), Ortho)]),
            row("T", "turntable", &[(Char('t'), Turntable)]),
            row("Enter", "camera as at the beginning", &[(Enter, Reset)]),
        ],
    ),
    (
        "Surface",
        &[
            row(
                "0 - 9",
                "uniform level",
                &[
                    (Char('0'), Level(0)),
                    (Char('1'), Level(1)),
                    (Char('2'), Level(2)),
                    (Char('3'), Level(3)),
                    (Char('4'), Level(4)),
                    (Char('5'), Level(5)),
                    (Char('6'), Level(6)),
                    (Char('7'), Level(7)),
                    (Char('8'), Level(8)),
                    (Char('9'), Level(9)),
                ],
            ),
            row(
                "+ -",
                "level up, down",
                &[
                    (Char('+'), Levels(1)),
                    (Char('='), Levels(1)),
                    (Char('-'), Levels(-1)),
                ],
            ),
            row("A", "adaptive or uniform", &[(Char('a'), Adaptive)]),
            row(
                ", .",
                "adaptive: coarser, finer",
                &[(Char(','), Flatness(-1)), (Char('.'), Flatness(1))],
            ),
            row("L", "limit or refined", &[(Char('l'), LimitOrRefined)]),
            row(
                "V",
                "limit, refined, cage, qas, pn",
                &[
                    (Char('v'), Next(Cycle::Surface, 1)),
                    (Shift('v'), Next(Cycle::Surface, -1)),
                ],
            ),
            row(
                "N",
                "next scheme",
                &[
                    (Char('n'), Next(Cycle::Scheme, 1)),
                    (Shift('n'), Next(Cycle::Scheme, -1)),
                ],
            ),
        ],
    ),
    (
        "Picture",
        &[
            row(
                "C",
                "next shading",
                &[
                    (Char('c'), Next(Cycle::Shade, 1)),
                    (Shift('c'), Next(Cycle::Shade, -1)),
                ],
            ),
            row(
                "W G P X",
                "lines: tessellation, cage, patches, axes",
                &[
                    (Char('w'), Overlay("wireframe")),
                    (Char('g'), Overlay("cage")),
                    (Char('p'), Overlay("patches")),
                    (Char('x'), Overlay("axes")),
                ],
            ),
            row(
                "E K M",
                "lines: creases, boundaries, valences",
                &[
                    (Char('e'), Overlay("creases")),
                    (Char('k'), Overlay("boundaries")),
                    (Char('m'), Overlay("valences")),
                ],
            ),
            row("B", "dark or light window", &[(Char('b'), Backdrop)]),
            row(
                "S  F12",
                "save the picture",
                &[(Char('s'), Save), (F(12), Save)],
            ),
            row("?", "print its command line", &[(Char('?'), Print)]),
        ],
    ),
    (
        "Window",
        &[
            row(
                "Left Right",
                "previous, next model",
                &[(Left, Model(-1)), (Right, Model(1))],
            ),
            row(
                "Up  R",
                "read the files again",
                &[(Up, Reload), (Char('r'), Reload)],
            ),
            row("I", "figures: some, all, none", &[(Char('i'), Figures)]),
            row("H  F1", "this sheet", &[(Char('h'), Help), (F(1), Help)]),
            row("Esc  Q", "quit", &[(Escape, Quit), (Char('q'), Quit)]),
        ],
    ),
];

/// What a key does. A letter with a shift key does what it does without, unless the table says otherwise.
#[must_use]
pub(super) fn action(press: Press) -> Option<Action> {
    let rows = || TABLE.iter().flat_map(|(_, rows)| rows.iter());
    let find = |wanted: Press| {
        let presses = rows().flat_map(|r| r.presses.iter());
        presses.clone().find(|(p, _)| *p == wanted).map(|(_, a)| *a)
    };
    find(press).or_else(|| match press {
        Shift(letter) => find(Char(letter)),
        _ => None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_key_does_one_thing() {
        let presses: Vec<Press> = TABLE
            .iter()
            .flat_map(|(_, rows)| rows.iter())
            .flat_map(|r| r.presses.iter().map(|(p, _)| *p))
            .collect();
        for (k, p) in presses.iter().enumerate() {
            assert!(!presses[..k].contains(p), "{p:?} twice");
        }
        assert!(presses.len() > 40);
    }

    #[test]
    fn shift_falls_back_to_the_letter() {
        assert_eq!(action(Shift('c')), Some(Next(Cycle::Shade, -1)));
        assert_eq!(action(Shift('q')), Some(Quit));
        assert_eq!(action(Char('~')), None);
    }

    /// The table of the module's documentation is the table.
    #[test]
    fn the_documentation_lists_the_keys() {
        let docs = include_str!("mod.rs");
        for (heading, rows) in TABLE {
            for r in *rows {
                let line = format!("//! | {heading} | `{}` | {} |", r.keys, r.does);
                assert!(docs.contains(&line), "missing in mod.rs: {line}");
            }
        }
    }
}

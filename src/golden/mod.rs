#![doc = include_str!("guide.md")]

mod assert;
mod folders;
mod report;

use crate::compare::{Comparison, SizeMismatch, Tolerance, compare};
use crate::film::DeepImage;

pub use crate::assert_image;
pub use assert::{Failure, Goldens, Outcome, assert_image_at};
pub use folders::{Folders, FoldersError, Found, PictureError, compare_files, read_picture, stage};
pub use report::{Page, Pictures, Shown};

/// What came of holding a picture against its golden.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Verdict {
    /// The same pixels.
    Equal,
    /// Different, but let pass.
    Within(Comparison),
    /// Different.
    Different(Comparison),
    /// Not the same size.
    Size(SizeMismatch),
    /// There is no golden yet.
    New,
    /// There is a golden and no picture.
    Dead,
    /// One of the two cannot be read; which, and why.
    Unreadable(String),
}

impl Verdict {
    /// Whether a test passes.
    #[must_use]
    pub fn passes(&self) -> bool {
        matches!(self, Self::Equal | Self::Within(_))
    }
    /// In words.
    #[must_use]
    pub fn word(&self) -> &'static str {
        match self {
            Self::Equal => "equal",
            Self::Within(_) => "within tolerance",
            Self::Different(_) => "different",
            Self::Size(_) => "different size",
            Self::New => "without golden",
            Self::Dead => "dead golden",
            Self::Unreadable(_) => "unreadable",
        }
    }
    /// The figures, in lines; empty where there are none.
    #[must_use]
    pub fn figures(&self) -> String {
        match self {
            Self::Within(c) | Self::Different(c) => c.to_string(),
            Self::Size(e) => format!("golden and new: {e}"),
            Self::Unreadable(why) => why.clone(),
            Self::Equal | Self::New | Self::Dead => String::new(),
        }
    }
    /// Whether a new picture may take the place of the golden.
    #[must_use]
    pub fn is_acceptable(&self) -> bool {
        matches!(
            self,
            Self::Different(_) | Self::Size(_) | Self::New | Self::Unreadable(_)
        )
    }
    /// Class of the word on the page.
    fn class(&self) -> &'static str {
        match self {
            Self::Equal => "equal",
            Self::Within(_) => "within",
            Self::New => "new",
            Self::Dead => "dead",
            Self::Different(_) | Self::Size(_) | Self::Unreadable(_) => "bad",
        }
    }
}

/// Holds a picture against its golden.
#[must_use]
pub fn judge(golden: &DeepImage, new: &DeepImage, tolerance: &Tolerance) -> Verdict {
    match compare(golden, new) {
        Err(e) => Verdict::Size(e),
        Ok(c) if c.differing() == 0 => Verdict::Equal,
        Ok(c) if c.within(tolerance) => Verdict::Within(c),
        Ok(c) => Verdict::Different(c),
    }
}

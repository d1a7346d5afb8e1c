//! `earmark completions` and `earmark man`: texts about the program itself.

use super::exit::{Code, Failure};
use super::outputs::print_text;
use clap::{Args, Command};
use clap_complete::Shell;

#[derive(Args, Debug)]
pub(crate) struct Completions {
    /// Shell to write a script for
    #[arg(value_enum)]
    shell: Shell,
}

#[derive(Args, Debug)]
pub(crate) struct Manual {
    /// Verb to describe [default: the program as a whole]
    #[arg(value_name = "VERB")]
    verb: Option<String>,
}

/// Bytes that are text.
fn print(bytes: &[u8]) -> Result<(), Failure> {
    print_text(&String::from_utf8_lossy(bytes))
}

pub(crate) fn completions(a: &Completions, mut command: Command) -> Result<(), Failure> {
    let mut out = Vec::new();
    clap_complete::generate(a.shell, &mut command, "earmark", &mut out);
    print(&out)
}

pub(crate) fn manual(a: &Manual, mut command: Command) -> Result<(), Failure> {
    command.build();
    let (page, title) = match &a.verb {
        None => (command, "earmark".to_owned()),
        Some(verb) => {
            let found = command.find_subcommand(verb).cloned();
            let found = found.ok_or_else(|| Failure::usage(format!("there is no verb {verb}")))?;
            let found = found.version(env!("CARGO_PKG_VERSION"));
            // The name of a page has no blank.
            (found, format!("earmark-{verb}"))
        }
    };
    let mut out = Vec::new();
    let rendered = clap_mangen::Man::new(page).title(title).render(&mut out);
    rendered.map_err(|e| Failure::new(Code::Io, format!("earmark: {e}")))?;
    print(&out)
}

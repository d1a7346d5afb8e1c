//! The program as scripts see it: help texts, exit codes, messages, outputs that appear whole or not at all.

#[path = "cli/bench.rs"]
mod bench;
#[path = "cli/documented.rs"]
mod documented;
#[path = "cli/harness.rs"]
mod harness;
#[path = "cli/refine.rs"]
mod refine;
#[path = "cli/refused.rs"]
mod refused;
#[path = "cli/said.rs"]
mod said;
#[path = "cli/texts.rs"]
mod texts;
#[path = "cli/written.rs"]
mod written;

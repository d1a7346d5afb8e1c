//! What the program writes beside a single picture: further outputs of a frame, turns, sheets, comparisons, and texts about itself.

#[path = "outputs/aov.rs"]
mod aov;
#[path = "outputs/batch.rs"]
mod batch;
#[path = "outputs/compare.rs"]
mod compare;
#[path = "cli/harness.rs"]
mod harness;
#[path = "outputs/help.rs"]
mod help;
#[path = "outputs/turntable.rs"]
mod turntable;

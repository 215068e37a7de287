//! Recordings as files: segments, and the commands that read and make them.

mod commands;
mod made;

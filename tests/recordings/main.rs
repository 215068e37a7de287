//! Recordings as files: damage, segments, and the commands that read and make them.

mod commands;
mod damage;
mod made;

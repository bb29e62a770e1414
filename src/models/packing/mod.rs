//! Event-driven hard discs.

//! The model and its observer.

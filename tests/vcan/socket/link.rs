//! What is known of an interface without a controller.

use tertius::bus::socket::{LinkError, LinkState, is_virtual};

use super::vcan::{Vcan, ip};

#[test]
fn a_virtual_interface_has_no_controller() {
    let vcan = Vcan::new("t-link");
    let link = LinkState::read("t-link").unwrap();
    assert!(link.up && link.is_fd());
    assert_eq!((link.bit_rate, link.data_bit_rate, link.restart_ms), (None, None, None));
    assert_eq!((link.state, link.transmit_errors, link.receive_errors), (None, None, None));
    assert_eq!(link.queue_length, Some(1000));
    ip(&["link", "set", "t-link", "txqueuelen", "10"]);
    vcan.down();
    let link = LinkState::read("t-link").unwrap();
    assert_eq!((link.up, link.queue_length), (false, Some(10)));
    ip(&["link", "set", "t-link", "mtu", "16"]);
    assert!(!LinkState::read("t-link").unwrap().is_fd());
    assert!(is_virtual("t-link").unwrap());
    assert!(!is_virtual("lo").unwrap());
}

#[test]
fn an_interface_that_is_not_there_is_named() {
    let error = LinkState::read("t-nothing").unwrap_err();
    assert!(matches!(error, LinkError::NoInterface { .. }));
    assert!(error.to_string().contains("t-nothing"), "{error}");
    let error = is_virtual("t-nothing").unwrap_err();
    assert!(matches!(error, LinkError::NoInterface { .. }), "{error}");
}

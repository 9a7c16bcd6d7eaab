"""Load cells, torque transducers and balances that send lines over a serial port unasked."""

module cylfuse

go 1.19

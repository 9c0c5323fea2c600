"""The mapping language: where quantities stand in a payload, as data. For any device."""

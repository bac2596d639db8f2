namespace sinew::hil {}

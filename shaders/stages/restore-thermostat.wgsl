// restore-thermostat

"""The layer below the contracts: executor, rates, waiting and waking. Pure, or given a clock."""

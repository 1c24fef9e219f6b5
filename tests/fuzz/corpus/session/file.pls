2f3621edea7469e3 {"pliant_session":1,"program":"pliant 0.1.0","scan":"0000000000000005","source":{"file":"/scan.nrrd","series":"1.2"}}
